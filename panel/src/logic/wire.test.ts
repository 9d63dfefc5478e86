import { describe, expect, it } from 'vitest';
import { appended, fileText, kFramesKept, matches, visible, type WireFrame } from './wire';

const frame = (over: Partial<WireFrame> = {}): WireFrame => ({
  sequence: 1,
  at_s: 1.5,
  to: 'host',
  hex: '55 50 04 0F E8',
  name: 'battery',
  fields: [['volts', 7.4]],
  text: 'battery: volts 7.4',
  kind: 'good',
  ...over,
});
const all = { way: 'both', words: '', fill: true } as const;

describe('the filter', () => {
  it('is about the way, the words in either language, and whole bytes', () => {
    const one = frame();
    const german = 'Batterie: Volt 7.4';
    expect(matches(one, all, german)).toBe(true);
    expect(matches(one, { ...all, way: 'device' }, german)).toBe(false);
    expect(matches(one, { ...all, words: 'volt batterie' }, german)).toBe(true);
    expect(matches(one, { ...all, words: 'BATTERY' }, german)).toBe(true);
    expect(matches(one, { ...all, words: 'version' }, german)).toBe(false);
    expect(matches(one, { ...all, words: '0x04 0f' }, german)).toBe(true);
    expect(matches(one, { ...all, words: '040F' }, german)).toBe(true);
    expect(matches(one, { ...all, words: '05' }, german), 'half of two bytes').toBe(false);
    expect(matches(one, { ...all, words: '0F 04' }, german)).toBe(false);
  });
  it('leaves out transfers that say nothing', () => {
    expect(matches(frame({ kind: 'fill' }), { ...all, fill: false }, '')).toBe(false);
    expect(matches(frame({ kind: 'bad' }), { ...all, fill: false }, '')).toBe(true);
  });
});

describe('what is kept', () => {
  it('has each message once and at most so many', () => {
    const first = appended([], [frame({ sequence: 1 }), frame({ sequence: 2 })]);
    expect(appended(first, [frame({ sequence: 2 }), frame({ sequence: 3 })]).map((one) => one.sequence)).toEqual([1, 2, 3]);
    const many = Array.from({ length: kFramesKept + 5 }, (_, i) => frame({ sequence: i + 1 }));
    expect(appended([], many)).toHaveLength(kFramesKept);
    expect(appended([], many)[0]!.sequence).toBe(6);
  });
  it('shows the rows that are in sight', () => {
    expect(visible(2000, 20, 0, 200)).toEqual({ first: 0, end: 18 });
    expect(visible(2000, 20, 1000, 200)).toEqual({ first: 42, end: 68 });
    expect(visible(5, 20, 0, 200)).toEqual({ first: 0, end: 5 });
  });
  it('is written down row by row', () => {
    const text = fileText('# six', [frame({ to: 'device', axes: [1, 2], text: 'x' })], (one) => one.text);
    expect(text.split('\n')).toEqual([
      '# six',
      '# seconds  way  axis  bytes (hex)  message',
      '      1.500000  host -> device  J1+J2  55 50 04 0F E8  x',
      '',
    ]);
  });
});
