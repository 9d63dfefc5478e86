/** A robot in a pose as lines: from the side, in the plane that it reaches out in, and from above. */
import { linkPoses, toolPose } from './kinematics';
import { compose } from './pose';
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
