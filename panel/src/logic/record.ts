/** A record of a run (docs/records.md) as rows over time, for plots and for the 3D view. */
import { errorSentence } from '../i18n';
import { readMcap } from './mcap';
import type { Frame, JointFrame } from './history';
import type { Pose } from './types';

export interface RecordEvent {
  t: number;
  kind: string;
  text: string;
  grave: boolean;
}

export interface RunRecord {
  robot: string;
  /** Of the robot's file. */
  model: string;
  program: string;
  /** Wall clock at its start, ms. */
  startedMs: number;
  joints: { name: string; measure: 'angle' | 'length' }[];
  /** t counts from the first message, s. */
  frames: Frame[];
  tool: { t: number; pose: Pose }[];
  events: RecordEvent[];
  lost: number;
  whole: boolean;
}

type Json = Record<string, unknown>;
const isObject = (value: unknown): value is Json => typeof value === 'object' && value !== null && !Array.isArray(value);
const numberOf = (value: unknown): number | undefined =>
  typeof value === 'number' && Number.isFinite(value) ? value : undefined;
const textOf = (value: unknown): string => (typeof value === 'string' ? value : '');

function parse(data: Uint8Array): Json | null {
  try {
    const json: unknown = JSON.parse(new TextDecoder().decode(data));
    return isObject(json) ? json : null;
  } catch {
    return null;
  }
}

function jointFrame(json: Json): JointFrame {
  const position = numberOf(json['position_rad']) ?? numberOf(json['position_m']);
  const commanded = numberOf(json['commanded_rad']) ?? numberOf(json['commanded_m']);
  return { position: position ?? NaN, commanded: commanded ?? NaN, measured: json['quality'] === 'measured' };
}

function poseOf(json: Json): Pose | null {
  const pose = json['pose'];
  if (!isObject(pose) || !isObject(pose['position']) || !isObject(pose['orientation'])) return null;
  const { x, y, z } = pose['position'];
  const turn = pose['orientation'];
  const all = [x, y, z, turn['w'], turn['x'], turn['y'], turn['z']].map(numberOf);
  if (all.some((one) => one === undefined)) return null;
  const [px, py, pz, w, qx, qy, qz] = all as number[];
  return { p: [px!, py!, pz!], q: [w!, qx!, qy!, qz!] };
}

/** @throws McapError  where the file is none of ours, or damaged */
export function readRecord(bytes: Uint8Array): RunRecord {
  const file = readMcap(bytes);
  const run = file.metadata['sinew.run'] ?? {};
  const record: RunRecord = {
    robot: run['robot'] ?? '',
    model: run['model'] ?? '',
    program: run['program'] ?? '',
    startedMs: Number(run['started_ns'] ?? 0) / 1e6,
    joints: [],
    frames: [],
    tool: [],
    events: [],
    lost: Number(file.metadata['sinew.end']?.['lost'] ?? 0),
    whole: file.whole,
  };
  const messages = [...file.messages].sort((a, b) => (a.time < b.time ? -1 : a.time > b.time ? 1 : 0));
  const first = messages[0]?.time ?? 0n;
  for (const message of messages) {
    const topic = file.channels.get(message.channel)?.topic ?? '';
    const t = Number(message.time - first) / 1e9;
    const what = topic.slice(topic.lastIndexOf('/') + 1);
    if (record.robot === '' && topic.startsWith('/')) record.robot = topic.split('/')[1] ?? '';
    const json = parse(message.data);
    if (!json) continue;
    if (what === 'joint_states' && isObject(json['joints'])) takeJoints(record, t, json['joints']);
    else if (what === 'tool') {
      const pose = poseOf(json);
      if (pose) record.tool.push({ t, pose });
    } else if (what === 'events') takeEvent(record, t, json);
  }
  return record;
}

function takeJoints(record: RunRecord, t: number, joints: Json): void {
  if (record.joints.length === 0) {
    record.joints = Object.keys(joints).map((name) => ({ name, measure: 'angle' }));
  }
  const rows = record.joints.map((joint): JointFrame => {
    const json = joints[joint.name];
    if (!isObject(json)) return { position: NaN, commanded: NaN, measured: false };
    if ('position_m' in json || 'commanded_m' in json) joint.measure = 'length';
    return jointFrame(json);
  });
  record.frames.push({ t, robots: { [record.robot]: { at: t, joints: rows } } });
}

function errorText(json: Json): string {
  const [code, sentence, joint] = [json['code'], json['sentence'], json['joint']].map(textOf);
  return errorSentence({ code: code || undefined, sentence, joint: joint || undefined });
}

function takeEvent(record: RunRecord, t: number, json: Json): void {
  const kind = textOf(json['kind']);
  const error = isObject(json['error']) ? errorText(json['error']) : '';
  const lost = numberOf(json['lost']);
  const rest = textOf(json['state']) || textOf(json['cause']) || (lost === undefined ? '' : String(lost));
  record.events.push({ t, kind, text: error || rest, grave: kind === 'fault' || kind === 'failed' || kind === 'refused' || kind === 'lost' });
}

/** Index of the last of those that is not behind t; they stand in their order. */
export function lastBefore(all: readonly { t: number }[], t: number): number {
  let low = 0;
  let high = all.length - 1;
  if (high < 0 || all[0]!.t > t) return -1;
  while (low < high) {
    const middle = Math.ceil((low + high) / 2);
    if (all[middle]!.t <= t) low = middle;
    else high = middle - 1;
  }
  return low;
}

/** What the robot looked like then; nothing where a joint's place was not known. */
export function standAt(record: RunRecord, t: number): { joints: number[]; platform: Pose | undefined } | null {
  const k = lastBefore(record.frames, t);
  const row = k < 0 ? undefined : record.frames[k]!.robots[record.robot];
  if (!row) return null;
  const joints = row.joints.map((one) => (Number.isNaN(one.position) ? one.commanded : one.position));
  if (joints.some(Number.isNaN)) return null;
  const tool = record.tool[lastBefore(record.tool, t)];
  return { joints, platform: tool?.pose };
}

/** s from its first to its last frame. */
export const lengthOf = (record: RunRecord): number => record.frames.at(-1)?.t ?? 0;
