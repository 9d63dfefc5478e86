/**
 * The shells of what a tool can reach: of a chain or linkage the farthest and the nearest place in
 * each direction of its plane, by looking at a grid of joints, turned about the base's axis as far as
 * that turns; of a platform the farthest level place in each direction from its home.
 */
import { legLengths, toolPose } from '../logic/kinematics';
import { fromJson } from '../logic/pose';
import type { RobotModel, Vec3 } from '../logic/types';
import { jointLimits } from '../logic/store';

export interface Shell {
  points: Vec3[];
  /** Points a row; rows follow each other. */
  row: number;
  /** Triangles, by place in `points`. */
  faces: [number, number, number][];
}

const kDirections = 72;
const kTurns = 48;

/** Holes that are smaller than this share of the reach come from the grid, not from the robot. */
const kHoleLeast = 0.08;

type Flat = [number, number];

export interface Outline {
  /** Height of what the directions are counted from. */
  centre: number;
  rim: Flat[];
  /** What is nearer cannot be reached; nothing of a robot that reaches all up to its base. */
  hole: Flat[] | null;
}

/** In the plane through the base's axis: distance from it and height, by direction. */
export function outline(model: RobotModel): Outline {
  const found = sampled(model);
  const heights = found.map((one) => one[1]);
  const centre = (Math.max(...heights) + Math.min(...heights)) / 2;
  const far = new Array<number>(kDirections).fill(0);
  const near = new Array<number>(kDirections).fill(Infinity);
  for (const [r, z] of found) {
    const angle = Math.atan2(z - centre, r);
    const at = Math.round(((angle + Math.PI / 2) / Math.PI) * (kDirections - 1));
    const away = Math.hypot(r, z - centre);
    far[at] = Math.max(far[at]!, away);
    near[at] = Math.min(near[at]!, away);
  }
  const place = (away: number, i: number): Flat => {
    const angle = -Math.PI / 2 + (Math.PI * i) / (kDirections - 1);
    return [away * Math.cos(angle), centre + away * Math.sin(angle)];
  };
  const inner = smooth(near, Math.min);
  const outer = smooth(far, Math.max);
  const deepest = Math.max(...inner.filter((_, i) => far[i]! > 0));
  if (deepest < kHoleLeast * Math.max(...far)) return { centre, rim: outer.map(place), hole: null };
  // Where it reaches nothing straight up or down, both shells end at the last direction, in one ring.
  const first = far.findIndex((one) => one > 0);
  const last = far.findLastIndex((one) => one > 0);
  const whole = (i: number) => i >= first && i <= last;
  const ring = (i: number): Flat => {
    const end = i < first ? first : last;
    return place(inner[end]!, end);
  };
  return {
    centre,
    rim: outer.map((away, i) => (whole(i) ? place(away, i) : ring(i))),
    hole: inner.map((away, i) => (whole(i) ? place(away, i) : ring(i))),
  };
}

/** Its joints, that about which all else turns first: where a SCARA is lifted as a whole it is the second one. */
function turnsFirst(model: RobotModel): number[] {
  const all = model.joints.map((_, i) => i);
  const first = Math.max(0, model.joints.findIndex((joint) => joint.kind !== 'prismatic'));
  return [first, ...all.filter((i) => i !== first)];
}

function sampled(model: RobotModel): Flat[] {
  const steps = model.kind === 'palletizer' ? 40 : 22;
  const [, second, third] = turnsFirst(model);
  const home = model.joints.map((joint) => jointLimits(joint).home);
  const found: Flat[] = [];
  const range = (index: number | undefined): number[] => {
    const joint = index === undefined ? undefined : model.joints[index];
    if (!joint) return [0];
    const { lower, upper } = jointLimits(joint);
    return Array.from({ length: steps }, (_, i) => lower + ((upper - lower) * i) / (steps - 1));
  };
  const bends = model.kind === 'serial' && model.joints.length > 3 ? 8 : 1;
  const bend = model.joints.length >= 6 ? 4 : 3;
  const ahead = toolPose(model, home).p;
  // Its firmware ignores what is nearer; behind its base's axis it would have to turn instead.
  const tooNear = (p: Vec3): boolean =>
    model.kind === 'palletizer' && p[0] * ahead[0] + p[1] * ahead[1] < model.geometry.radius_min_m * Math.hypot(ahead[0], ahead[1]);
  for (const a of range(second)) {
    for (const b of range(third)) {
      // docs/kinematics/maxarm.md: its elbow is always up.
      if (model.kind === 'palletizer' && b > a) continue;
      for (let k = 0; k < bends; ++k) {
        const q = [...home];
        if (second !== undefined) q[second] = a;
        if (third !== undefined) q[third] = b;
        const joint = model.joints[bend];
        if (bends > 1 && joint) {
          const { lower, upper } = jointLimits(joint);
          q[bend] = lower + ((upper - lower) * k) / (bends - 1);
        }
        const { p } = toolPose(model, q);
        if (tooNear(p)) continue;
        found.push([Math.hypot(p[0], p[1]), p[2]]);
      }
    }
  }
  return found;
}

/** A grid of joints leaves notches where no sample fell: the outermost of the neighbours, evened. */
function smooth(away: number[], outermost: (...values: number[]) => number): number[] {
  const around = (list: number[], i: number) =>
    list.slice(Math.max(0, i - 3), Math.min(list.length, i + 4)).filter(Number.isFinite);
  const filled = away.map((_, i) => outermost(...around(away, i)));
  return filled.map((_, i) => {
    const all = around(filled, i);
    return all.reduce((sum, one) => sum + one, 0) / Math.max(1, all.length);
  });
}

function revolved(model: RobotModel): Shell {
  const { rim, hole } = outline(model);
  const first = jointLimits(model.joints[turnsFirst(model)[0]!]!);
  const home = toolPose(
    model,
    model.joints.map((joint) => jointLimits(joint).home),
  ).p;
  const zero = Math.atan2(home[1], home[0]);
  const sign = model.kind === 'palletizer' ? -1 : 1;
  const span = Math.min(first.upper - first.lower, 2 * Math.PI);
  // The hole goes on where the rim ends, and back.
  const flat = hole ? [...rim, ...[...hole].reverse()] : rim;
  const row = flat.length;
  const points: Vec3[] = [];
  const faces: [number, number, number][] = [];
  for (let k = 0; k <= kTurns; ++k) {
    const q = first.lower + (span * k) / kTurns;
    const angle = zero + sign * (q - first.home);
    for (const [r, z] of flat) points.push([r * Math.cos(angle), r * Math.sin(angle), z]);
  }
  for (let k = 0; k < kTurns; ++k) {
    for (let i = 0; i + 1 < row; ++i) {
      const a = k * row + i;
      const b = a + row;
      faces.push([a, b, a + 1], [b, b + 1, a + 1]);
    }
  }
  return { points, row, faces };
}

function platformShell(model: RobotModel & { kind: 'hexapod' }): Shell {
  const home = fromJson(model.geometry.home);
  const fits = (p: Vec3): boolean =>
    legLengths(model, { p, q: home.q }).every((length, i) => {
      const { lower, upper } = jointLimits(model.joints[i]!);
      return length >= lower && length <= upper;
    });
  const rows = 24;
  const turns = 48;
  const points: Vec3[] = [];
  const faces: [number, number, number][] = [];
  for (let i = 0; i <= rows; ++i) {
    const up = -Math.PI / 2 + (Math.PI * i) / rows;
    for (let k = 0; k <= turns; ++k) {
      const about = (2 * Math.PI * k) / turns;
      const way: Vec3 = [Math.cos(up) * Math.cos(about), Math.cos(up) * Math.sin(about), Math.sin(up)];
      let least = 0;
      let most = 0.5;
      for (let n = 0; n < 14; ++n) {
        const s = (least + most) / 2;
        const p: Vec3 = [home.p[0] + way[0] * s, home.p[1] + way[1] * s, home.p[2] + way[2] * s];
        if (fits(p)) least = s;
        else most = s;
      }
      points.push([home.p[0] + way[0] * least, home.p[1] + way[1] * least, home.p[2] + way[2] * least]);
    }
  }
  for (let i = 0; i < rows; ++i) {
    for (let k = 0; k < turns; ++k) {
      const a = i * (turns + 1) + k;
      const b = a + turns + 1;
      faces.push([a, b, a + 1], [b, b + 1, a + 1]);
    }
  }
  return { points, row: turns + 1, faces };
}

export function reachShell(model: RobotModel): Shell {
  return model.kind === 'hexapod' ? platformShell(model) : revolved(model);
}
