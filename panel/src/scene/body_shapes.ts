/** What a body is drawn with: the shapes of its file or, where it says none, bars along its table. */
import { jointLimits } from '../logic/store';
import type { DhRow, RobotModel, ShapeJson, Vec3 } from '../logic/types';

/** Of the arm's length: a bar at its base, and one at its hand. */
const kWide = 0.05;
const kSlim = 0.022;

const isLong = (a: Vec3, b: Vec3): boolean => Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]) > 1e-3;

const bar = (link: number, from_m: Vec3, to_m: Vec3, radius_m: number): ShapeJson => ({ link, form: 'capsule', from_m, to_m, radius_m });

/**
 * What slides: on a column of the link before where the arm goes on behind it, else as a shaft of its own.
 * Frames: the link's.
 */
function slideBar(rows: DhRow[], i: number, joint: RobotModel['joints'][number], radius: number): ShapeJson {
  const row = rows[i]!;
  const { lower, upper } = jointLimits(joint);
  if (rows.slice(i).some(({ a_m }) => Math.abs(a_m) > 1e-3)) return bar(i, [0, 0, row.d_m + lower], [0, 0, row.d_m + upper], radius);
  const [sin, cos] = [Math.sin(row.alpha_rad), Math.cos(row.alpha_rad)];
  const far = Math.abs(row.d_m + lower) > Math.abs(row.d_m + upper) ? row.d_m + lower : row.d_m + upper;
  return bar(i + 1, [-row.a_m, -far * sin, -far * cos], [-row.a_m, 0, 0], radius);
}

/** Each link's way from its joint's axis to the next one: first along the axis, then across. Frames: a link's own. */
function chainBars(model: RobotModel & { kind: 'serial' }): ShapeJson[] {
  const rows = model.geometry.dh;
  const reach = rows.reduce((sum, row) => sum + Math.abs(row.a_m) + Math.abs(row.d_m), 0);
  return rows.flatMap((row, i) => {
    const radius_m = reach * (kWide - ((kWide - kSlim) * i) / Math.max(1, rows.length - 1));
    const [sin, cos] = [Math.sin(row.alpha_rad), Math.cos(row.alpha_rad)];
    const begin: Vec3 = [-row.a_m, -row.d_m * sin, -row.d_m * cos];
    const knee: Vec3 = [-row.a_m, 0, 0];
    const bars: [Vec3, Vec3][] = row.slides ? [[knee, [0, 0, 0]]] : [[begin, knee], [knee, [0, 0, 0]]];
    const own = bars.filter(([from, to]) => isLong(from, to)).map(([from, to]) => bar(i + 1, from, to, radius_m));
    return row.slides ? [slideBar(rows, i, model.joints[i]!, 0.7 * radius_m), ...own] : own;
  });
}

function linkageBars(model: RobotModel & { kind: 'palletizer' }): ShapeJson[] {
  const g = model.geometry;
  const radius = kSlim * (g.base_height_m + g.upper_arm_m + g.forearm_m);
  return [
    bar(1, [0, 0, 0], [0, -g.shoulder_offset_m, g.base_height_m], 2.2 * radius),
    bar(2, [0, 0, 0], [0, -g.upper_arm_m, 0], 1.4 * radius),
    bar(3, [0, 0, 0], [0, -g.forearm_m, 0], radius),
  ];
}

export function drawnShapes(model: RobotModel): ShapeJson[] {
  if (model.shapes.length > 0 || model.kind === 'hexapod') return model.shapes;
  return model.kind === 'serial' ? chainBars(model) : linkageBars(model);
}
