import { describe, expect, it } from 'vitest';
import { jointsOf, sameSettings, trimOf, trimText, withFound, withSetting } from './settings';

describe('settings', () => {
  it('are sorted by joints', () => {
    expect(jointsOf(['joint.base.turn', 'joint.base.trim_rad', 'joint.leg1.turn', 'way_factor'])).toEqual([
      { joint: 'base', can: ['turn', 'trim_rad'] },
      { joint: 'leg1', can: ['turn'] },
    ]);
  });

  it('are set and taken away without a trace', () => {
    expect(withSetting({ a: '1' }, 'b', '2')).toEqual({ a: '1', b: '2' });
    expect(withSetting({ a: '1', b: '2' }, 'b', null)).toEqual({ a: '1' });
    expect(sameSettings({ a: '1', b: '2' }, { b: '2', a: '1' })).toBe(true);
    expect(sameSettings({ a: '1' }, { a: '1', b: '2' })).toBe(false);
    expect(withFound({ port: 'p', 'joint.a.turn': 'other' }, { 'joint.b.trim_rad': '0.1' })).toEqual({ port: 'p', 'joint.b.trim_rad': '0.1' });
  });

  it('have trims in degrees for people and in radians for the controller', () => {
    expect(Number(trimOf('2.5'))).toBeCloseTo((2.5 * Math.PI) / 180, 9);
    expect(Number(trimOf('-2,5°'))).toBeCloseTo((-2.5 * Math.PI) / 180, 9);
    expect(trimOf('0')).toBeNull();
    expect(trimOf(' ')).toBeNull();
    expect(trimText(trimOf('2.5')!)).toBe('2.50');
    expect(trimText(undefined)).toBe('');
    // What is no number is for the controller to refuse.
    expect(trimOf('two')).toBe('two');
    expect(trimText('two')).toBe('two');
  });
});
