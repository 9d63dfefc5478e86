/**
 * A joint's range in the 3D view with where it is: of what turns a sector about its axis, of what
 * slides a sleeve along it, as long as its end may move.
 */
import {
  BufferGeometry,
  CylinderGeometry,
  Group,
  Line,
  LineLoop,
  Mesh,
  Quaternion,
  RingGeometry,
  Vector3,
} from 'three';
import { compose } from '../logic/pose';
import { jointLimits } from '../logic/store';
import type { Pose, RobotModel } from '../logic/types';
import { axisFrame, place } from './body';
import type { Materials } from './look';

const kUp = new Vector3(0, 1, 0);
/** Wider than a leg. m. */
const kSleeve = 0.019;

/** In the robot's base frame. @param poses  of its links */
export function limitMark(model: RobotModel, joint: number, poses: Pose[], value: number, look: Materials): Group | null {
  const group = slides(model, joint) ? sleeve(model, joint, poses, value, look) : sector(model, joint, poses, value, look);
  if (group) group.renderOrder = 5;
  return group;
}

function sector(model: RobotModel, joint: number, poses: Pose[], value: number, look: Materials): Group | null {
  const at = axisFrame(model, joint, poses);
  if (!at) return null;
  const { lower, upper } = jointLimits(model.joints[joint]!);
  const reach = 0.16 * Math.max(0.6, sizeOf(model));
  const span = Math.min(upper - lower, 2 * Math.PI);
  const range = new Mesh(new RingGeometry(reach * 0.55, reach, 64, 1, lower + at.offset, span), look.limit);
  const angle = value + at.offset;
  const needle = new BufferGeometry().setFromPoints([
    new Vector3(Math.cos(angle) * reach * 0.45, Math.sin(angle) * reach * 0.45, 0),
    new Vector3(Math.cos(angle) * reach * 1.12, Math.sin(angle) * reach * 1.12, 0),
  ]);
  const group = new Group();
  group.add(range, new Line(needle, look.needle));
  place(group, at.pose);
  return group;
}

const slides = (model: RobotModel, joint: number): boolean => model.joints[joint]?.kind === 'prismatic';

/** Where what slides is at 0, and which way it goes: a leg from its foot, a chain's joint along its axis. */
function axisOf(model: RobotModel, joint: number, poses: Pose[]): { from: Vector3; way: Vector3 } | null {
  if (model.kind === 'hexapod') {
    const base = model.geometry.base_anchors_m[joint];
    const anchor = model.geometry.platform_anchors_m[joint];
    const plate = poses.at(-1);
    if (!base || !anchor || !plate) return null;
    const from = new Vector3(...base);
    return { from, way: new Vector3(...compose(plate, { p: anchor, q: [1, 0, 0, 0] }).p).sub(from).normalize() };
  }
  const row = model.kind === 'serial' ? model.geometry.dh[joint] : undefined;
  const before = poses[joint];
  if (!row || !before) return null;
  const from = new Vector3(...compose(before, { p: [0, 0, row.d_m], q: [1, 0, 0, 0] }).p);
  const ahead = new Vector3(...compose(before, { p: [0, 0, row.d_m + 1], q: [1, 0, 0, 0] }).p);
  return { from, way: ahead.sub(from) };
}

function sleeve(model: RobotModel, joint: number, poses: Pose[], value: number, look: Materials): Group | null {
  const axis = axisOf(model, joint, poses);
  if (!axis) return null;
  const { lower, upper } = jointLimits(model.joints[joint]!);
  const range = new Mesh(new CylinderGeometry(kSleeve, kSleeve, upper - lower, 32, 1, true), look.limit);
  range.position.y = (lower + upper) / 2;
  const rim = (at: number, radius: number) => {
    const dots = Array.from({ length: 32 }, (_, i) => {
      const angle = (2 * Math.PI * i) / 32;
      return new Vector3(radius * Math.cos(angle), at, radius * Math.sin(angle));
    });
    return new LineLoop(new BufferGeometry().setFromPoints(dots), look.needle);
  };
  const group = new Group();
  group.add(range, rim(lower, kSleeve), rim(upper, kSleeve), rim(value, kSleeve * 0.8), rim(value, kSleeve * 1.6));
  group.position.copy(axis.from);
  group.quaternion.copy(new Quaternion().setFromUnitVectors(kUp, axis.way));
  return group;
}

/** How long its links are together, m. */
function sizeOf(model: RobotModel): number {
  if (model.kind === 'serial') {
    return model.geometry.dh.reduce((sum, row) => sum + Math.abs(row.a_m) + Math.abs(row.d_m), 0);
  }
  return model.kind === 'palletizer' ? model.geometry.upper_arm_m + model.geometry.forearm_m : 0.4;
}
