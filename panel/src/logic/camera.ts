/** What a cell's camera sees, and rows that pick it up. */
import { inverse, add, rotate } from './pose';
import type { CubeVerdictJson, Pose, SeenCubeJson, Vec3 } from './types';

const mm = (value: number): string => `${(1000 * value).toFixed(1).replace(/\.0$/, '')}mm`;

/** A place of the cell as its robot sees it. */
export function inBase(base: Pose, p: Vec3): Vec3 {
  const to = inverse(base);
  return add(to.p, rotate(to.q, p));
}

/** Cubes whose place is known, and that are not in the basket. */
export const onTable = (cubes: readonly SeenCubeJson[]): SeenCubeJson[] =>
  cubes.filter((cube) => cube.x_m !== undefined && !cube.in_basket);

export function pickRow(base: Pose, cube: SeenCubeJson): string {
  const p = inBase(base, [cube.x_m!, cube.y_m!, cube.z_m!]);
  return `pick at=${p.map(mm).join(',')}`;
}

/** Where the basket stands, and where in it, is looked up when the row is planned. */
export const placeRow = (basket: string): string => `place ${basket}`;

/** All of a color, or all, one after the other. */
export function sortRows(basket: string, color: string | null): string {
  const which = color ? ` color=${color}` : '';
  return [`repeat while seen${which}`, `  pick${which}`, `  ${placeRow(basket)}`, 'end'].join('\n');
}

/** What was said of this cube, however it has been seen since: of the same color, within a third of an edge. */
export function verdictOf(cube: SeenCubeJson, verdicts: readonly CubeVerdictJson[]): CubeVerdictJson | undefined {
  if (cube.x_m === undefined) return undefined;
  const far = (one: CubeVerdictJson) => Math.hypot(one.x_m - cube.x_m!, one.y_m - cube.y_m!, one.z_m - cube.z_m!);
  return verdicts.find((one) => one.color === cube.color && far(one) < (cube.edge_m ?? 0.025) / 3);
}

const middle = (cube: SeenCubeJson): [number, number] => [
  cube.top_px.reduce((sum, p) => sum + p[0], 0) / cube.top_px.length,
  cube.top_px.reduce((sum, p) => sum + p[1], 0) / cube.top_px.length,
];
/** The same cube in the next picture: of its color and less than half an edge away; null: none is. */
export function sameCube(was: SeenCubeJson, cubes: readonly SeenCubeJson[]): number | null {
  const [x, y] = middle(was);
  const edge = Math.hypot(was.top_px[1]![0] - was.top_px[0]![0], was.top_px[1]![1] - was.top_px[0]![1]);
  const found = cubes.findIndex((cube) => {
    const [u, v] = middle(cube);
    return cube.color === was.color && Math.hypot(u - x, v - y) < edge / 2;
  });
  return found < 0 ? null : found;
}

/** How many of each color are on the table and in the basket; the commonest first. */
export function countColors(cubes: readonly SeenCubeJson[]): { color: string; table: number; basket: number }[] {
  const counts = new Map<string, { color: string; table: number; basket: number }>();
  for (const cube of cubes) {
    const one = counts.get(cube.color) ?? { color: cube.color, table: 0, basket: 0 };
    if (cube.in_basket) ++one.basket;
    else ++one.table;
    counts.set(cube.color, one);
  }
  return [...counts.values()].sort((a, b) => b.table + b.basket - a.table - a.basket || a.color.localeCompare(b.color));
}

/** A sentence as the key of its translation. */
export const whyKey = (why: string): string => why.toLowerCase().replace(/[^a-z]+/g, '_').replace(/^_|_$/g, '');

const kPaint: Record<string, string> = {
  red: '#d2392f', orange: '#e97f1e', yellow: '#e9c62c', green: '#3f9e4d', blue: '#2f62c4',
  purple: '#7d4bb0', pink: '#e08ab4', black: '#2b2d30', wood: '#c9a071',
};
export const paintOf = (color: string): string => kPaint[color] ?? '#888888';
