import { describe, expect, it } from 'vitest';
import { fileKind, keepShelf, loadShelf, nameOfFile, type Kept } from './shelf';
import { sketch } from './thumbnail';
import fixture from './models.fixture.json';
import type { RobotModel } from './types';

const memory = (): Kept & { all: Map<string, string> } => {
  const all = new Map<string, string>();
  return { all, getItem: (key) => all.get(key) ?? null, setItem: (key, value) => void all.set(key, value) };
};

describe('the shelf', () => {
  it('gives back what was put there, for each kind of robot', () => {
    const kept = memory();
    const shelf = { programs: { wave: 'wait 1s\n' }, points: [{ name: 'a', joints: [1] }], draft: { name: 'wave', text: 'x' } };
    expect(keepShelf(kept, 'learm', shelf)).toBe(true);
    expect(loadShelf(kept, 'learm')).toEqual(shelf);
    expect(loadShelf(kept, 'maxarm').programs).toEqual({});
  });

  it('shows nothing of what it cannot read', () => {
    const kept = memory();
    kept.setItem('sinew.shelf.learm', '{"programs":{"../x":"a","ok":3,"good":"b"},"points":[{"name":1},{"name":"p"}]}');
    expect(loadShelf(kept, 'learm')).toEqual({ programs: { good: 'b' }, points: [], draft: { name: '', text: '' } });
    kept.setItem('sinew.shelf.learm', '{');
    expect(loadShelf(kept, 'learm').points).toEqual([]);
  });

  it('says where a browser keeps nothing', () => {
    const full: Kept = { getItem: () => null, setItem: () => { throw new Error('quota'); } };
    expect(keepShelf(full, 'learm', loadShelf(full, 'learm'))).toBe(false);
  });

  it('knows files by their endings', () => {
    expect(['a.sinew', 'points.toml', 'a.G', 'x.pos', 'x.png', 'x'].map(fileKind)).toEqual([
      'program', 'points', 'gcode', 'pos', 'unknown', 'unknown',
    ]);
    expect(nameOfFile('C:\\a b\\3 my wave.sinew')).toBe('my_wave');
    expect(nameOfFile('1.sinew')).toBe('program');
  });
});

describe('a thumbnail', () => {
  for (const model of Object.values(fixture as unknown as Record<string, RobotModel>)) {
    it(`of ${model.robot} stays in its picture at home and is all numbers`, () => {
      const home = model.joints.map((one) => one.home_rad ?? one.home_m ?? 0);
      const { side, top, sideTool } = sketch(model, home, undefined, 64);
      for (const [x, y] of [...side.flat(), ...top.flat(), sideTool]) {
        expect(x).toBeGreaterThanOrEqual(-4);
        expect(x).toBeLessThanOrEqual(68);
        expect(y).toBeGreaterThanOrEqual(-4);
        expect(y).toBeLessThanOrEqual(68);
      }
    });
  }
});
