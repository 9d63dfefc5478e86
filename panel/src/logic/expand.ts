/**
 * A program as one text: points as numbers, called programs in their place. `robot.preview` takes rows
 * only, without points and calls; what is checked and runs is the program itself with both beside it.
 */
import { toolPose } from './kinematics';
import { add, fixedXyz, fromFixedXyz, multiply, rotate } from './pose';
import { jointRow, readQuantity } from './quantities';
import { linesOf, splitLine } from './rows';
import { jointLimits } from './store';
import { toDeg } from './units';
import type { Point } from './points';
import type { Pose, RobotModel, Vec3 } from './types';

export interface Missing {
  line: number;
  what: 'point' | 'program';
  name: string;
}

export interface Expanded {
  text: string;
  /** Of each of its lines, from 1, the line of the program itself that it comes from. */
  lines: number[];
  /** Rows of the program itself that name what is not there; of each row the first. */
  missing: Missing[];
  /** Rows whose place only a run can tell: what stands in them cannot be asked for beforehand. */
  open: number[];
}

const kDepthMax = 8;

/** The program that a row calls, if it calls one. */
export const calledIn = (raw: string): string | undefined => /^call\s+(\S+)$/.exec(splitLine(raw).body)?.[1];

export function expand(
  text: string,
  model: RobotModel,
  points: readonly Point[],
  programs: Readonly<Record<string, string>>,
): Expanded {
  const out: string[] = [];
  const lines: number[] = [];
  const open: number[] = [];
  const missing: Missing[] = [];
  const lacks = (one: Missing) => {
    if (missing.every((other) => other.line !== one.line)) missing.push(one);
  };
  const put = (part: string, depth: number, own: number | null, inside: readonly string[]) => {
    linesOf(part).forEach((raw, i) => {
      const { body } = splitLine(raw);
      const line = own ?? i + 1;
      const called = calledIn(raw);
      const theirs = called !== undefined && Object.hasOwn(programs, called) ? programs[called] : undefined;
      if (theirs !== undefined && depth < kDepthMax && !inside.includes(called!)) {
        put(theirs, depth + 1, line, [...inside, called!]);
        return;
      }
      if (called !== undefined) lacks({ line, what: 'program', name: called });
      const replaced = withPoints(body, model, points);
      if ('unknown' in replaced) lacks({ line, what: 'point', name: replaced.unknown });
      if ('open' in replaced) open.push(line);
      out.push('body' in replaced ? replaced.body : body);
      lines.push(line);
    });
  };
  put(text, 0, null, []);
  return { text: out.join('\n'), lines, missing, open };
}

/** Programs that this one calls, and those that they call, as `program.run` takes them. */
export function calledBy(text: string, programs: Readonly<Record<string, string>>): Record<string, string> {
  const found: Record<string, string> = {};
  const look = (part: string) => {
    for (const raw of linesOf(part)) {
      const name = calledIn(raw);
      if (!name || name in found || !Object.hasOwn(programs, name)) continue;
      found[name] = programs[name]!;
      look(programs[name]!);
    }
  };
  look(text);
  return found;
}

/** A row with numbers for its points. */
export type Replaced = { body: string } | { unknown: string } | { open: true };

const kTools = new Set(['joint', 'move', 'line', 'arc', 'spline']);
const kDifference = /^d(x|y|z|rx|ry|rz|pitch|roll)=(.*)$/;

export function withPoints(body: string, model: RobotModel, points: readonly Point[]): Replaced {
  const tokens = body.split(/[ \t]+/);
  const word = tokens[0] ?? '';
  if (!kTools.has(word)) return { body };
  const named = (name: string) => points.find((one) => one.name === name);
  let trouble: Replaced | null = null;
  const placeOf = (name: string): string => {
    const point = named(name);
    const place = point && placeWords(point, model);
    trouble ??= point ? (place ? null : { open: true }) : { unknown: name };
    return place ? place.join(',') : name;
  };
  const rest = tokens.slice(1).map((one) => {
    if (one.startsWith('via=') && !one.includes(',')) return `via=${placeOf(one.slice(4))}`;
    return word === 'spline' && !/[,=]/.test(one) ? placeOf(one) : one;
  });
  if (trouble) return trouble;
  const at = rest.findIndex((one) => one.startsWith('to='));
  if (at < 0) return { body: [word, ...rest].join(' ') };
  const point = named(rest[at]!.slice(3));
  if (!point) return { unknown: rest[at]!.slice(3) };
  const others = rest.filter((_, i) => i !== at);
  const differs = others.some((one) => kDifference.test(one));
  // To the very joints, where no difference of the tool and no way of it is asked for.
  if (point.joints && (word === 'joint' || (word === 'move' && !differs))) return withJoints(word, model, point, others);
  return withTool(word, model, point, others);
}

/** Differences of joints are part of the number: a row has one of both. */
function withJoints(word: string, model: RobotModel, point: Point, others: string[]): Replaced {
  const joints = [...point.joints!];
  const kept = others.filter((one) => {
    const match = /^d\.([^=]+)=(.*)$/.exec(one);
    const i = match ? model.joints.findIndex((joint, at) => joint.name === match[1] || match[1] === `J${at + 1}`) : -1;
    const read = match && i >= 0 ? readQuantity(match[2]!, jointLimits(model.joints[i]!).measure) : null;
    if (read) joints[i]! += read.value;
    return !read;
  });
  const rows = word === 'joint' ? kept : kept.filter((one) => !one.startsWith('frame='));
  return { body: [jointRow(model, joints, 4), ...rows].join(' ') };
}

function withTool(word: string, model: RobotModel, point: Point, others: string[]): Replaced {
  const pose = knownPose(point, model);
  const turns = point.place ? { ...point.place.turns } : {};
  const p: Vec3 | null = point.place ? [point.place.x, point.place.y, point.place.z] : (pose?.p ?? null);
  if (!p) return { open: true };
  if (point.joints && model.task === 'pitch_roll') {
    const [, shoulder = 0, elbow = 0, wrist = 0, roll = 0] = point.joints;
    Object.assign(turns, { pitch: shoulder + elbow + wrist, roll });
  }
  const shift: Vec3 = [0, 0, 0];
  const spin: Vec3 = [0, 0, 0];
  const inTool = others.includes('frame=tool');
  const kept = others.filter((one) => {
    const match = kDifference.exec(one);
    if (!match) return !one.startsWith('frame=');
    const axis = ['x', 'y', 'z'].indexOf(match[1]!);
    const turn = ['rx', 'ry', 'rz'].indexOf(match[1]!);
    const value = readQuantity(match[2]!, axis >= 0 ? 'length' : 'angle')?.value ?? 0;
    if (axis >= 0) shift[axis]! += value;
    else if (turn >= 0) spin[turn]! += value;
    else turns[match[1]!] = (turns[match[1]!] ?? 0) + value;
    return false;
  });
  const turned = spin.some((one) => one !== 0);
  // How the tool is turned when it comes there is not known where the point does not say it.
  if ((turned || (inTool && shift.some((one) => one !== 0))) && !pose) return { open: true };
  const place = add(p, inTool ? rotate(pose!.q, shift) : shift);
  const words = ['x', 'y', 'z'].map((axis, i) => `${axis}=${mm(place[i]!)}`);
  if (pose && (model.task === 'pose' || model.task === 'yaw' || model.task === 'approach')) {
    const turn = fromFixedXyz(spin);
    const q = turned ? (inTool ? multiply(pose.q, turn) : multiply(turn, pose.q)) : pose.q;
    fixedXyz(q).forEach((one, i) => words.push(`${['rx', 'ry', 'rz'][i]}=${deg(one)}`));
  } else {
    for (const [name, turn] of Object.entries(turns)) words.push(`${name}=${deg(turn)}`);
  }
  return { body: [word, ...words, ...kept].join(' ') };
}

/** Place and orientation of a point, where it has both. */
function knownPose(point: Point, model: RobotModel): Pose | null {
  if (point.joints) {
    return model.kind === 'hexapod' && !point.platform ? null : toolPose(model, point.joints, point.platform);
  }
  const { x, y, z, turns } = point.place!;
  const { rx, ry, rz } = turns;
  if (rx === undefined || ry === undefined || rz === undefined) return null;
  return { p: [x, y, z], q: fromFixedXyz([rx, ry, rz]) };
}

const mm = (value: number): string => `${Number((value * 1e3).toFixed(4))}mm`;
const deg = (value: number): string => `${Number(toDeg(value).toFixed(4))}deg`;

function placeWords(point: Point, model: RobotModel): string[] | null {
  if (point.place) return [point.place.x, point.place.y, point.place.z].map(mm);
  return knownPose(point, model)?.p.map(mm) ?? null;
}
