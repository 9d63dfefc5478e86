import { describe, expect, it } from 'vitest';
import { decimalMark, timeSpan, duration, parseQuantity, shown } from './units';

describe('parseQuantity', () => {
  it('takes any unit, and the usual one where none is said', () => {
    expect(parseQuantity('90', 'angle')).toBeCloseTo(Math.PI / 2, 12);
    expect(parseQuantity('1.5rad', 'angle')).toBe(1.5);
    expect(parseQuantity('−90°', 'angle')).toBeCloseTo(-Math.PI / 2, 12);
    expect(parseQuantity('250', 'length')).toBeCloseTo(0.25, 12);
    expect(parseQuantity('0.1 m', 'length')).toBeCloseTo(0.1, 12);
    expect(parseQuantity('2in', 'length')).toBeCloseTo(0.0508, 12);
    expect(parseQuantity('3,5', 'length')).toBeCloseTo(0.0035, 12);
  });
  it('takes nothing else', () => {
    for (const text of ['', 'x', '1 deg', '1..2', '1e999', 'NaN', '5 5']) {
      expect(parseQuantity(text, 'length'), text).toBeNull();
    }
  });
});

describe('shown', () => {
  it('has mm and degrees, and no negative zero', () => {
    expect(shown(Math.PI / 2, 'angle')).toBe('90.0');
    expect(shown(-0.1234, 'length')).toBe('−123.4');
    expect(shown(-1e-9, 'length')).toBe('0.0');
  });
});

describe('numbers in German', () => {
  it('have a comma, which may be typed as well', () => {
    decimalMark.value = ',';
    expect(shown(-0.0123, 'length')).toBe('−12,3');
    expect(duration(12.34)).toBe('12,3 s');
    expect(parseQuantity(shown(-0.0123, 'length'), 'length')).toBeCloseTo(-0.0123, 6);
    decimalMark.value = '.';
    expect(shown(-0.0123, 'length')).toBe('−12.3');
  });
});

describe('duration', () => {
  it('is as coarse as it is long', () => {
    expect(duration(0.4)).toBe('0.40 s');
    expect(duration(12.34)).toBe('12.3 s');
    expect(duration(125)).toBe('2 min 05 s');
    expect(duration(3840)).toBe('1 h 04 min');
  });
});

describe('a time span', () => {
  it('is one time where it is sure, else from and to', () => {
    expect(timeSpan(1.4, 1.4)).toBe('1.4 s');
    expect(timeSpan(0, 2)).toBe('≤ 2.0 s');
    expect(timeSpan(3, 5.5)).toBe('3.0 s – 5.5 s');
    expect(timeSpan(125, 125)).toBe('2 min 05 s');
    expect(timeSpan(0, 0)).toBe('0.0 s');
  });
});
