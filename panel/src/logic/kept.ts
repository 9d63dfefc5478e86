/**
 * Programs and points as the controller keeps them. Each has a revision; whoever saves says which one it
 * was made from, so that two browsers do not overwrite each other.
 */
import { refusalSentence } from '../i18n';
import { writePoints, type Point } from './points';
import { fixedXyz } from './pose';
import { RpcError } from './rpc';
import type { Shelf } from './shelf';
import type { Caller } from './store';
import type { FlatPoseJson, RobotModel } from './types';
import type { Measure } from './units';

export interface KeptProgram {
  text: string;
  revision: number;
}
export interface Kept {
  programs: Record<string, KeptProgram>;
  points: Point[];
  pointsRevision: number;
}

interface ProgramRow {
  name: string;
  revision: number;
}
interface PointJson {
  name: string;
  position_rad?: number[];
  position_m?: number[];
  position_rad_m?: number[];
  /** Where the tool is at those joints. */
  pose?: FlatPoseJson;
  tool?: { x_m: number; y_m: number; z_m: number; quaternion_wxyz?: [number, number, number, number]; pitch_rad?: number; roll_rad?: number };
  source?: string;
  taught_at?: string;
}
interface PointsJson {
  revision: number;
  points: PointJson[];
}

export function pointOf(json: PointJson): Point {
  const point: Point = { name: json.name };
  const joints = json.position_rad ?? json.position_m ?? json.position_rad_m;
  if (joints) point.joints = joints;
  if (json.pose) point.platform = { p: [json.pose.x_m, json.pose.y_m, json.pose.z_m], q: json.pose.quaternion_wxyz };
  if (json.tool) {
    const { x_m, y_m, z_m, quaternion_wxyz, pitch_rad, roll_rad } = json.tool;
    const turns: Record<string, number> = {};
    if (quaternion_wxyz) [turns['rx'], turns['ry'], turns['rz']] = fixedXyz(quaternion_wxyz) as [number, number, number];
    if (pitch_rad !== undefined) turns['pitch'] = pitch_rad;
    if (roll_rad !== undefined) turns['roll'] = roll_rad;
    point.place = { x: x_m, y: y_m, z: z_m, turns };
  }
  if (json.source) point.source = json.source;
  if (json.taught_at) point.taughtAt = json.taught_at;
  return point;
}

/** Everything of a kind of robot; only what has another revision than before is asked for. */
export async function fetchKept(rpc: Caller, robot: string, before: Kept | null): Promise<Kept> {
  const { programs } = await rpc.call<{ programs: ProgramRow[] }>('programs.list', { robot });
  const points = await rpc.call<PointsJson>('points.list', { robot });
  const kept: Kept = { programs: {}, points: points.points.map(pointOf), pointsRevision: points.revision };
  for (const { name, revision } of programs) {
    const known = before?.programs[name];
    if (known?.revision === revision) {
      kept.programs[name] = known;
      continue;
    }
    const { text, revision: now } = await rpc.call<KeptProgram>('programs.load', { robot, name });
    kept.programs[name] = { text, revision: now };
  }
  return kept;
}

/** Why something was not kept: somebody else was first, or a sentence. */
export type NotKept = { why: 'conflict'; revision: number } | { why: 'refused'; sentence: string } | { why: 'lost' };

export function notKept(error: unknown): NotKept {
  if (!(error instanceof RpcError)) return { why: 'lost' };
  const data = (error.data ?? {}) as { code?: string; revision?: number };
  if (data.code === 'conflict') return { why: 'conflict', revision: data.revision ?? 0 };
  return { why: 'refused', sentence: refusalSentence(error) };
}

export async function saveProgram(
  rpc: Caller,
  robot: string,
  name: string,
  text: string,
  revision: number,
): Promise<KeptProgram | NotKept> {
  try {
    const saved = await rpc.call<{ revision: number }>('programs.save', { robot, name, text, revision });
    return { text, revision: saved.revision };
  } catch (error) {
    return notKept(error);
  }
}

export type PointChange =
  | { kind: 'save'; points: readonly Point[] }
  | { kind: 'remove'; name: string }
  | { kind: 'rename'; name: string; to: string };

type Points = Pick<Kept, 'points' | 'pointsRevision'>;

/**
 * One change of the points. Where somebody else has changed the file meanwhile, but not the points that
 * this is about, it is tried once more on top of that.
 */
export async function changePoints(
  rpc: Caller,
  robot: string,
  model: RobotModel,
  measures: readonly Measure[],
  change: PointChange,
  now: Points,
): Promise<Points | NotKept> {
  const send = async (revision: number): Promise<Points> => {
    const points = change.kind === 'save' ? { points: writePoints(model.robot, change.points, measures) } : {};
    const names = change.kind === 'save' ? {} : { name: change.name, ...(change.kind === 'rename' ? { to: change.to } : {}) };
    const told = await rpc.call<PointsJson>(`points.${change.kind}`, { robot, ...points, ...names, revision });
    return { points: told.points.map(pointOf), pointsRevision: told.revision };
  };
  try {
    return await send(now.pointsRevision);
  } catch (error) {
    const why = notKept(error);
    if (why.why !== 'conflict') return why;
  }
  try {
    const told = await rpc.call<PointsJson>('points.list', { robot });
    const fresh = { points: told.points.map(pointOf), pointsRevision: told.revision };
    const meant = change.kind === 'save' ? change.points.map((one) => one.name) : [change.name];
    if (meant.some((name) => !same(find(now, name), find(fresh, name)))) return { why: 'conflict', revision: told.revision };
    return await send(fresh.pointsRevision);
  } catch (error) {
    return notKept(error);
  }
}

const find = (points: Points, name: string): Point | undefined => points.points.find((one) => one.name === name);
const same = (a: Point | undefined, b: Point | undefined): boolean => JSON.stringify(a) === JSON.stringify(b);

/** What the page shows: all of the controller, and what is in this browser only. */
export function merged(local: Shelf, kept: Kept | null): Shelf {
  if (!kept) return local;
  const texts = Object.fromEntries(Object.entries(kept.programs).map(([name, one]) => [name, one.text]));
  return {
    draft: local.draft,
    programs: { ...local.programs, ...texts },
    points: [...kept.points, ...local.points.filter((one) => !find(kept, one.name))],
  };
}

/** What the controller does not have: programs by name, with the text of this browser, and points. */
export function onlyHere(local: Shelf, kept: Kept | null): { programs: Record<string, string>; points: Point[] } {
  if (!kept) return { programs: {}, points: [] };
  return {
    programs: Object.fromEntries(Object.entries(local.programs).filter(([name, text]) => kept.programs[name]?.text !== text)),
    points: local.points.filter((one) => !find(kept, one.name)),
  };
}
