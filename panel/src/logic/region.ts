/** The outline of where a robot can take cubes, from the grid that `robot.cube_reach` gives. */
import type { CubeReachJson } from './types';

export type Place = [number, number];

/** Sides of the smallest outline that is told: around four points of the grid. */
const kLeast = 9;

/** Where neighbouring points of the grid differ: loops around those that fit, m in the cell. */
export function outlines(grid: CubeReachJson, fits: (letter: string) => boolean): Place[][] {
  const { rows } = grid;
  const height = rows.length;
  const width = grid.columns;
  const inside = (i: number, j: number): boolean => i >= 0 && j >= 0 && i < width && j < height && fits(rows[j]![i]!);
  // Middles of the edges between points, in halves of a step; each leads to the next one, those inside at its left.
  const next = new Map<string, Place>();
  for (let j = -1; j < height; ++j) {
    for (let i = -1; i < width; ++i) {
      const corners = [inside(i, j), inside(i + 1, j), inside(i + 1, j + 1), inside(i, j + 1)];
      const edges: Place[] = [[2 * i + 1, 2 * j], [2 * i + 2, 2 * j + 1], [2 * i + 1, 2 * j + 2], [2 * i, 2 * j + 1]];
      for (let side = 0; side < 4; ++side) {
        // Leaves the square where the inside ends along its rim.
        if (!corners[side] || corners[(side + 1) % 4]) continue;
        let from = side;
        do from = (from + 3) % 4;
        while (!(corners[(from + 1) % 4] && !corners[from]));
        next.set(edges[side]!.join(), edges[from]!);
      }
    }
  }
  const loops: Place[][] = [];
  while (next.size > 0) {
    const loop: Place[] = [];
    let key = next.keys().next().value as string;
    for (let to = next.get(key); to; to = next.get(key)) {
      next.delete(key);
      loop.push([grid.x_m + (grid.step_m * to[0]) / 2, grid.y_m + (grid.step_m * to[1]) / 2]);
      key = to.join();
    }
    // A few points by themselves are the planner's luck at the rim.
    if (loop.length >= kLeast) loops.push(loop);
  }
  return loops;
}

/** Its corners cut, twice. */
export function smooth(loop: readonly Place[], rounds = 2): Place[] {
  let points = [...loop];
  for (let round = 0; round < rounds; ++round) {
    points = points.flatMap((a, i): Place[] => {
      const b = points[(i + 1) % points.length]!;
      return [
        [0.75 * a[0] + 0.25 * b[0], 0.75 * a[1] + 0.25 * b[1]],
        [0.25 * a[0] + 0.75 * b[0], 0.25 * a[1] + 0.75 * b[1]],
      ];
    });
  }
  return points;
}

export const taken = (letter: string): boolean => letter === 's' || letter === 't';
export const straightDown = (letter: string): boolean => letter === 's';
