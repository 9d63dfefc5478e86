import { describe, expect, it } from 'vitest';
import { outlines, smooth, straightDown, taken } from './region';
import type { CubeReachJson } from './types';

const grid = (rows: string[]): CubeReachJson => ({
  robot: 'left', edge_m: 0.025, z_m: 0, step_m: 0.01, x_m: 1, y_m: 2, columns: rows[0]!.length, done: 1, rows,
});
const area = (loop: readonly (readonly [number, number])[]): number =>
  loop.reduce((sum, [x, y], i) => {
    const [u, v] = loop[(i + 1) % loop.length]!;
    return sum + (x * v - u * y) / 2;
  }, 0);

describe('the region where cubes can be taken', () => {
  it('has an outline around it, and one around each hole, which turns the other way', () => {
    const ring = grid(['-------', '-ttttt-', '-t---t-', '-t---t-', '-t---t-', '-ttttt-', '-------']);
    const loops = outlines(ring, taken);
    expect(loops).toHaveLength(2);
    const areas = loops.map(area).sort((a, b) => b - a);
    expect(Math.sign(areas[0]!)).toBe(-Math.sign(areas[1]!));
    const rim = loops.find((loop) => Math.abs(area(loop)) > 15e-4)!;
    for (const [x, y] of rim) {
      expect(x).toBeGreaterThan(1.004);
      expect(x).toBeLessThan(1.056);
      expect(y).toBeGreaterThan(2.004);
      expect(y).toBeLessThan(2.056);
    }
  });
  it('may come in several parts, up to the rim of the grid; points alone are left out', () => {
    const two = grid(['ttt----', 'ttt----', 'ttt--s-', '-------', '----sss', '----sss', '----sss']);
    expect(outlines(two, taken)).toHaveLength(2);
    expect(outlines(two, straightDown)).toHaveLength(1);
    expect(outlines(grid(['---', '---']), taken)).toEqual([]);
    expect(outlines(grid(['...', '...']), taken)).toEqual([]);
  });
  it('is smooth without going far', () => {
    const [loop] = outlines(grid(['tttt', 'tttt', 'tttt', 'tttt']), taken);
    const round = smooth(loop!);
    expect(round.length).toBe(4 * loop!.length);
    expect(Math.abs(area(round))).toBeGreaterThan(0.9 * Math.abs(area(loop!)));
  });
});
