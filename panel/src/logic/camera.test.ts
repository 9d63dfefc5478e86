import { describe, expect, it } from 'vitest';
import { countColors, inBase, onTable, pickRow, placeRow, sameCube, sortRows, verdictOf, whyKey } from './camera';
import { fromFixedXyz } from './pose';
import type { SeenCubeJson } from './types';

const cube = (color: string, more: Partial<SeenCubeJson> = {}): SeenCubeJson => ({
  color, confidence: 0.9, top_px: [[0, 0], [1, 0], [1, 1], [0, 1]], x_m: 1.2, y_m: 0.1, z_m: 0.025, ...more,
});
/** Its x points along the cell's y. */
const base = { p: [1, 0, 0] as [number, number, number], q: fromFixedXyz([0, 0, Math.PI / 2]) };

describe('cubes that a camera sees', () => {
  it('stand where their robot sees them', () => {
    const p = inBase(base, [1.2, 0.1, 0.025]);
    expect(p[0]).toBeCloseTo(0.1);
    expect(p[1]).toBeCloseTo(-0.2);
    expect(p[2]).toBeCloseTo(0.025);
  });
  it('are picked up and placed with rows in the robot’s own frame', () => {
    expect(pickRow(base, cube('red'))).toBe('pick at=100mm,-200mm,25mm');
    expect(placeRow('tray')).toBe('place tray');
    expect(sortRows('tray', 'red')).toBe('repeat while seen color=red\n  pick color=red\n  place tray\nend');
    expect(sortRows('tray', null)).toContain('repeat while seen\n  pick\n');
  });
  it('are counted by color, those in the basket apart', () => {
    const cubes = [cube('red'), cube('blue'), cube('red', { in_basket: 'tray' })];
    expect(countColors(cubes)).toEqual([
      { color: 'red', table: 1, basket: 1 },
      { color: 'blue', table: 1, basket: 0 },
    ]);
    expect(onTable([...cubes, cube('green', { x_m: undefined })]).map((one) => one.color)).toEqual(['red', 'blue']);
  });
  it('have the verdict of where they lie, also in the next picture', () => {
    const verdict = { color: 'red', x_m: 1.203, y_m: 0.102, z_m: 0.025, fine: false };
    expect(verdictOf(cube('red'), [verdict])).toBe(verdict);
    expect(verdictOf(cube('blue'), [verdict])).toBeUndefined();
    expect(verdictOf(cube('red', { x_m: 1.22 }), [verdict])).toBeUndefined();
  });
  it('are found again in the next picture', () => {
    const at = (color: string, x: number, y: number) =>
      cube(color, { top_px: [[x, y], [x + 40, y], [x + 40, y + 40], [x, y + 40]] });
    const was = at('red', 100, 100);
    expect(sameCube(was, [at('blue', 100, 100), at('red', 300, 100), at('red', 104, 97)])).toBe(2);
    expect(sameCube(was, [at('red', 125, 100), at('blue', 101, 100)])).toBeNull();
    expect(sameCube(was, [])).toBeNull();
  });
  it('have a key for each reason why something is none', () => {
    expect(whyKey('it is flat: printed, or a piece of paper')).toBe('it_is_flat_printed_or_a_piece_of_paper');
  });
});
