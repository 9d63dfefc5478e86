/**
 * A robot in a pose as lines: from the side, in the plane that it reaches out in, and from above. Of a
 * place without joints, which only a server could find, what it reaches and its tool there.
 */
import { linkPoses, toolPose } from './kinematics';
import type { Point } from './points';
import { compose, fromFixedXyz, fromJson, rotate } from './pose';
import type { Pose, RobotModel, Vec3 } from './types';

export type Dot = [number, number];

export interface Sketch {
  /** Lines of dots, x to the right and y down, in a picture of the size that was asked for. */
  side: Dot[][];
  top: Dot[][];
  /** Its tool in both. */
  sideTool: Dot;
  topTool: Dot;
  /** Height of its base's origin in the side view. */
  floor: number;
  topOrigin: Dot;
}

export function sketch(model: RobotModel, joints: readonly number[], platform: Pose | undefined, size: number): Sketch {
  const lines = bones(model, joints, platform);
  const tool = toolPose(model, joints, platform).p;
  // Out along where the tool is; straight ahead where it is above the base.
  const far = Math.hypot(tool[0], tool[1]);
  const out: Dot = model.kind === 'hexapod' ? [0, 1] : far > 0.02 ? [tool[0] / far, tool[1] / far] : [1, 0];
  // As large as it fits, and never so large that a folded arm fills the picture.
  const least = 0.55 * reachOf(model);
  const flat = [...lines.flat(), tool].map(([x, y, z]): Dot => [x * out[0] + y * out[1], z]);
  const span = (axis: 0 | 1): Dot => [Math.min(0, ...flat.map((dot) => dot[axis])), Math.max(0, ...flat.map((dot) => dot[axis]))];
  const [left, right] = span(0);
  const [bottom, top] = span(1);
  const scale = (0.84 * size) / Math.max(right - left, top - bottom, least);
  const floor = 0.94 * size + scale * bottom;
  const middle = size / 2 - (scale * (left + right)) / 2;
  const aside = ([x, y, z]: Vec3): Dot => [middle + scale * (x * out[0] + y * out[1]), floor - scale * z];
  const wide = Math.max(least, ...lines.flat().map(([x, y]) => Math.hypot(x, y)), far);
  const small = (0.44 * size) / wide;
  // As somebody stands before it: x away from them, y to their left.
  const above = ([x, y]: Vec3): Dot => [size / 2 - small * y, size / 2 - small * x];
  return {
    side: lines.map((line) => line.map(aside)),
    top: lines.map((line) => line.map(above)),
    sideTool: aside(tool),
    topTool: above(tool),
    floor,
    topOrigin: [size / 2, size / 2],
  };
}

export interface PlaceSketch {
  sideReach: Dot[][];
  topReach: Dot[];
  /** The end of its tool, as far as it is known how that is turned. */
  sideWay: Dot[] | null;
  topWay: Dot[] | null;
  sideTool: Dot;
  topTool: Dot;
  floor: number;
  topOrigin: Dot;
  /** Where it stands. */
  sideBase: Dot[];
}

/** @param reach  lines in the plane through its base's axis: distance from it and height */
export function sketchPlace(model: RobotModel, place: Place, reach: Dot[][], size: number): PlaceSketch {
  const { x, y, z } = place;
  const far = Math.hypot(x, y);
  const radii = reach.flat().map(([r]) => r);
  const heights = [0, z, ...reach.flat().map(([, up]) => up)];
  const low = Math.min(...heights);
  const wide = Math.max(far, ...radii);
  // The base at the left, as the tool is always ahead of it.
  const scale = (0.84 * size) / Math.max(1.1 * wide, Math.max(...heights) - low);
  const floor = 0.94 * size + scale * low;
  const left = size / 2 - (scale * 0.95 * wide) / 2;
  const aside = ([r, up]: Dot): Dot => [left + scale * r, floor - scale * up];
  const small = (0.44 * size) / wide;
  const above = ([px, py]: Dot): Dot => [size / 2 - small * py, size / 2 - small * px];
  const out: Dot = far > 0.02 ? [x / far, y / far] : [1, 0];
  const way = toolWay(model, place, out);
  const back = 0.22 * wide;
  const [wx, wy, wz] = way ?? [0, 0, 0];
  const ring = (r: number): Dot[] =>
    Array.from({ length: 33 }, (_, i) => above([r * Math.cos((Math.PI * i) / 16), r * Math.sin((Math.PI * i) / 16)]));
  return {
    sideReach: reach.map((line) => line.map(aside)),
    topReach: ring(Math.max(...radii)),
    sideWay: way && [aside([far - back * (wx * out[0] + wy * out[1]), z - back * wz]), aside([far, z])],
    topWay: way && [above([x - back * wx, y - back * wy]), above([x, y])],
    sideTool: aside([far, z]),
    topTool: above([x, y]),
    floor,
    topOrigin: [size / 2, size / 2],
    sideBase: [aside([-0.05 * wide, 0]), aside([0.05 * wide, 0])],
  };
}

type Place = NonNullable<Point['place']>;

/** Where its tool points; a palletizer's points down always. */
function toolWay(model: RobotModel, { turns }: Place, out: Dot): Vec3 | null {
  if (model.task === 'point') return [0, 0, -1];
  const { rx, ry, rz, pitch } = turns;
  if (pitch !== undefined) return [out[0] * Math.sin(pitch), out[1] * Math.sin(pitch), Math.cos(pitch)];
  if (rx === undefined && ry === undefined && rz === undefined) return null;
  return rotate(fromFixedXyz([rx ?? 0, ry ?? 0, rz ?? 0]), [0, 0, 1]);
}

/** A platform where its place says; turned as it is at home where that says nothing. */
export function platformAt(model: RobotModel & { kind: 'hexapod' }, { x, y, z, turns }: Place): Pose {
  const { rx, ry, rz } = turns;
  const turned = rx !== undefined || ry !== undefined || rz !== undefined;
  return { p: [x, y, z], q: turned ? fromFixedXyz([rx ?? 0, ry ?? 0, rz ?? 0]) : fromJson(model.geometry.home).q };
}

function bones(model: RobotModel, joints: readonly number[], platform?: Pose): Vec3[][] {
  const poses = linkPoses(model, joints, platform);
  if (model.kind !== 'hexapod') {
    const dots = poses.map((one) => one.p);
    return [[[0, 0, 0], ...dots.slice(1), toolPose(model, joints, platform).p]];
  }
  const top = poses.at(-1)!;
  const ends = model.geometry.platform_anchors_m.map((one) => compose(top, { p: one, q: [1, 0, 0, 0] }).p);
  const base = model.geometry.base_anchors_m;
  return [[...base, base[0]!], [...ends, ends[0]!], ...base.map((one, i): Vec3[] => [one, ends[i]!])];
}

/** How far it can reach from its base, m. */
export function reachOf(model: RobotModel): number {
  if (model.kind === 'serial') {
    const arm = model.geometry.dh.slice(1).reduce((sum, row) => sum + Math.hypot(row.a_m, row.d_m), 0);
    return arm + (model.geometry.gripper?.reach_open_m ?? 0) + Math.hypot(...model.geometry.tool.xyz_m);
  }
  if (model.kind === 'palletizer') {
    const { upper_arm_m, forearm_m, shoulder_offset_m, tool_offset_m } = model.geometry;
    return upper_arm_m + forearm_m + shoulder_offset_m + tool_offset_m;
  }
  return 1.1 * Math.max(...model.geometry.base_anchors_m.map(([x, y]) => Math.hypot(x, y)), model.geometry.home.xyz_m[2]);
}
