/** Taught points: what they are, and the points.toml that `sinew run` reads beside a program. */
import { toolPose } from './kinematics';
import { fixedXyz } from './pose';
import { isAtRest, isPlaceKnown, jointLimits } from './store';
import { toDeg, toRad, type Measure } from './units';
import type { Pose, RobotModel, RobotStatus } from './types';

/** rad and m. */
export interface Point {
  name: string;
  joints?: number[];
  /** Place of the tool in the base frame, and how it is turned, by the words of a row. */
  place?: { x: number; y: number; z: number; turns: Record<string, number> };
  /** Of a hexapod, where its platform was when the point was taken: for its picture only. */
  platform?: Pose;
  source?: string;
  taughtAt?: string;
}

export const kPointName = /^[A-Za-z][A-Za-z0-9_-]{0,39}$/;
const kTurns = ['rx', 'ry', 'rz', 'pitch', 'roll'];

const number = (value: number, digits = 4): string => String(Number(value.toFixed(digits)));
const quoted = (text: string): string =>
  `"${text.replace(/[\\"]/g, '\\$&').replace(/[\x00-\x1f\x7f]/g, ' ')}"`;

/** @param measures  of its joints */
export function writePoints(robot: string, points: readonly Point[], measures: readonly Measure[]): string {
  const tables = points.map((point) => {
    const rows = [`[points.${point.name}]`, `robot = ${quoted(robot)}`];
    if (point.joints) {
      const values = point.joints.map((one, i) => (measures[i] === 'length' ? number(one * 1e3, 5) : number(toDeg(one))));
      if (new Set(measures).size > 1) {
        const texts = values.map((one, i) => quoted(one + (measures[i] === 'length' ? 'mm' : 'deg')));
        rows.push(`joints = [${texts.join(', ')}]`);
      } else {
        rows.push(`${measures[0] === 'length' ? 'legs_mm' : 'joints_deg'} = [${values.join(', ')}]`);
      }
    } else if (point.place) {
      for (const axis of ['x', 'y', 'z'] as const) rows.push(`${axis}_mm = ${number(point.place[axis] * 1e3)}`);
      for (const name of kTurns) {
        const turn = point.place.turns[name];
        if (turn !== undefined) rows.push(`${name}_deg = ${number(toDeg(turn))}`);
      }
    }
    if (point.source) rows.push(`source = ${quoted(point.source)}`);
    if (point.taughtAt) rows.push(`taught_at = ${quoted(point.taughtAt)}`);
    return rows.join('\n');
  });
  return tables.length > 0 ? `${tables.join('\n\n')}\n` : '';
}

export interface PointsFile {
  points: { robot: string; point: Point }[];
  complaints: { line: number; text: string }[];
}

const kHeader = /^\[\s*points\.(?:"([^"]*)"|([A-Za-z0-9_-]+))\s*\]$/;

/** As much TOML as such files are made of; all else is complained of with its line, never guessed. */
export function readPoints(toml: string): PointsFile {
  const file: PointsFile = { points: [], complaints: [] };
  let now: { robot: string; point: Point } | null = null;
  toml.split(/\r?\n/).forEach((raw, i) => {
    const complain = (text: string) => file.complaints.push({ line: i + 1, text });
    const code = withoutRemark(raw).trim();
    if (code === '') return;
    const header = kHeader.exec(code);
    if (header) {
      const name = header[1] ?? header[2]!;
      if (!kPointName.test(name)) complain(name);
      now = { robot: '', point: { name } };
      file.points.push(now);
      return;
    }
    const pair = /^([A-Za-z_]+)\s*=\s*(.*)$/.exec(code);
    if (!now || !pair || !take(now, pair[1]!, pair[2]!)) complain(code);
  });
  return file;
}

function withoutRemark(raw: string): string {
  let quote = false;
  for (let i = 0; i < raw.length; ++i) {
    if (raw[i] === '"' && raw[i - 1] !== '\\') quote = !quote;
    if (raw[i] === '#' && !quote) return raw.slice(0, i);
  }
  return raw;
}

function take(now: { robot: string; point: Point }, key: string, value: string): boolean {
  const { point } = now;
  const text = /^"((?:[^"\\]|\\["\\])*)"$/.exec(value)?.[1]?.replace(/\\(["\\])/g, '$1');
  if (key === 'robot' || key === 'source' || key === 'taught_at') {
    if (text === undefined) return false;
    if (key === 'robot') now.robot = text;
    else if (key === 'source') point.source = text;
    else point.taughtAt = text;
    return true;
  }
  if (key === 'joints_deg' || key === 'legs_mm' || key === 'joints') {
    const list = /^\[(.*)\]$/.exec(value)?.[1]?.split(',').map((one) => one.trim());
    if (list?.at(-1) === '') list.pop();
    const read = list?.map((one) => {
      const [, number, unit] = key === 'joints' ? (/^"(.*?)(deg|mm)"$/.exec(one) ?? []) : [one, one, key === 'legs_mm' ? 'mm' : 'deg'];
      if (number === undefined || !isNumber(number)) return NaN;
      return unit === 'mm' ? Number(number) * 1e-3 : toRad(Number(number));
    });
    if (!read || read.some(Number.isNaN)) return false;
    point.joints = read;
    return true;
  }
  if (!isNumber(value)) return false;
  const axis = /^([xyz])_mm$/.exec(key)?.[1] as 'x' | 'y' | 'z' | undefined;
  const turn = /^(rx|ry|rz|pitch|roll)_deg$/.exec(key)?.[1];
  if (!axis && !turn) return false;
  point.place ??= { x: 0, y: 0, z: 0, turns: {} };
  if (axis) point.place[axis] = Number(value) * 1e-3;
  else point.place.turns[turn!] = toRad(Number(value));
  return true;
}

const isNumber = (text: string): boolean => /^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i.test(text);

/** Why the place where a robot is now is none to be taught. */
export type NotTaught = 'moving' | 'unknown' | 'outside';

export function takePoint(
  name: string,
  model: RobotModel,
  status: RobotStatus | undefined,
  at: Date,
): Point | { wrong: NotTaught; joint?: string } {
  if (!status || !isPlaceKnown(status)) return { wrong: 'unknown' };
  if (!isAtRest(status) || (status.job && !status.job.over && status.job.phase === 'running')) {
    return { wrong: 'moving' };
  }
  const joints = status.joints.map((one) => one.position_rad ?? one.position_m ?? one.commanded_rad ?? one.commanded_m);
  if (joints.some((one) => one === undefined)) return { wrong: 'unknown' };
  const outside = model.joints.find((joint, i) => {
    const { lower, upper } = jointLimits(joint);
    return joints[i]! < lower - 1e-6 || joints[i]! > upper + 1e-6;
  });
  if (outside) return { wrong: 'outside', joint: outside.name };
  const point: Point = { name, joints: joints as number[], source: 'taught in the panel', taughtAt: at.toISOString().slice(0, 19) + 'Z' };
  if (model.kind === 'hexapod' && status.tool) {
    const { x_m, y_m, z_m, quaternion_wxyz } = status.tool;
    point.platform = { p: [x_m, y_m, z_m], q: quaternion_wxyz };
  }
  return point;
}

/** Where the tool is at a point, m and rad; nothing where only a server could tell. */
export function poseOf(point: Point, model: RobotModel): number[] | null {
  if (point.place) {
    const { x, y, z, turns } = point.place;
    return [x, y, z, ...['rx', 'ry', 'rz'].map((one) => turns[one]).filter((one) => one !== undefined)];
  }
  if (!point.joints) return null;
  if (model.kind === 'hexapod' && !point.platform) return null;
  const pose = toolPose(model, point.joints, point.platform);
  return [...pose.p, ...fixedXyz(pose.q)];
}

/** A name that is free: the wish itself, or with a number behind it. */
export function freeName(wish: string, taken: readonly string[]): string {
  if (!taken.includes(wish)) return wish;
  const stem = wish.replace(/\d+$/, '');
  for (let i = 2; ; ++i) if (!taken.includes(`${stem}${i}`)) return `${stem}${i}`;
}

