/**
 * The steps that there are, and what can be filled in at each: docs/programs.md as data. What a robot
 * cannot do is not offered; the server has the last word on every row.
 */
import { jointRow, readQuantity, written, type Quantity } from './quantities';
import { fixedXyz } from './pose';
import { readSlot, splitLine, writeSlot, type Slot } from './rows';
import { jointLimits } from './store';
import type { Pose, RobotModel } from './types';

export type FieldKind = Quantity | 'count' | 'into' | 'camera' | 'point' | 'program' | 'choice' | 'blend' | 'place' | 'text' | 'words';

export interface Field {
  id: string;
  slot: Slot;
  kind: FieldKind;
  /** What stands before it, where it is no word of this page's languages. */
  name?: string;
  choices?: readonly string[];
  lower?: number;
  upper?: number;
  /** Has to have a value. */
  needed?: boolean;
  /** Shown only where somebody wants more. */
  extra?: boolean;
}

export const kWords = [
  'joint',
  'move',
  'line',
  'arc',
  'spline',
  'home',
  'jaws',
  'gripper',
  'suction',
  'nozzle',
  'wait',
  'loop',
  'if',
  'call',
  'look',
  'pick',
  'place',
  'repeat',
  'velocity',
  'acceleration',
] as const;
export type Word = (typeof kWords)[number];

/** Colors of cubes, as src/sinew/vision/color_names.cc has them. */
const kColors = ['red', 'orange', 'yellow', 'green', 'blue', 'purple', 'pink', 'black', 'wood'] as const;

export function wordsOf(model: RobotModel): Word[] {
  const picks = model.kind === 'palletizer' || (model.kind === 'serial' && model.geometry.gripper !== undefined);
  const has: Partial<Record<Word, boolean>> = {
    jaws: model.kind === 'serial' && model.geometry.gripper !== undefined,
    gripper: model.robot === 'bigrobotarm',
    suction: model.kind === 'palletizer',
    nozzle: model.kind === 'palletizer',
    look: picks,
    pick: picks,
    place: picks,
    repeat: picks,
    velocity: model.takes_speed,
    acceleration: model.takes_speed,
  };
  return kWords.filter((one) => has[one] ?? true);
}

const kMoving = new Set(['joint', 'move', 'line', 'arc', 'spline']);
export const moves = (word: string): boolean => kMoving.has(word);

const share = { id: 'share', slot: { key: 'speed', unit: /%$/ }, kind: 'share', lower: 0.01, upper: 1 } as const;
const toolSpeed = { id: 'speed', slot: { key: 'speed', unit: /\/s$/ }, kind: 'speed', extra: true } as const;
const rest: Field[] = [
  { id: 'accel', slot: { key: 'accel' }, kind: 'accel', extra: true },
  { id: 'blend', slot: { key: 'blend' }, kind: 'blend', extra: true },
];
const keyed = (key: string, kind: FieldKind, more: Partial<Field> = {}): Field => ({
  id: key,
  name: key,
  slot: { key },
  kind,
  ...more,
});

function turnsOf(model: RobotModel, d = ''): Field[] {
  const names = { pose: ['rx', 'ry', 'rz'], yaw: ['rz'], approach: ['rx', 'ry', 'rz'], pitch_roll: ['pitch', 'roll'], point: [] };
  return names[model.task].map((one) => keyed(d + one, 'angle', { extra: true }));
}

function placeOf(model: RobotModel): Field[] {
  const differences = ['dx', 'dy', 'dz'].map((one) => keyed(one, 'length', { extra: true }));
  return [
    { id: 'to', slot: { key: 'to' }, kind: 'point' },
    ...['x', 'y', 'z'].map((one) => keyed(one, 'length')),
    ...turnsOf(model),
    ...differences,
    ...turnsOf(model, 'd'),
    { id: 'frame', slot: { key: 'frame' }, kind: 'choice', choices: ['base', 'tool'], extra: true },
  ];
}

export function fieldsOf(word: string, model: RobotModel): Field[] {
  const pace: Field[] = model.takes_speed ? [share, { id: 'time', slot: { key: 'time' }, kind: 'time', extra: true }] : [];
  switch (word) {
    case 'joint': {
      const joints = model.joints.map((joint, i): Field => {
        const { lower, upper, measure } = jointLimits(joint);
        return keyed(joint.name, measure, { lower, upper, slot: { key: joint.name, also: `J${i + 1}` } });
      });
      const ways = model.joints.map((joint) => keyed(`d.${joint.name}`, jointLimits(joint).measure, { extra: true }));
      return [{ id: 'to', slot: { key: 'to' }, kind: 'point' }, ...joints, ...ways, ...pace, ...rest];
    }
    case 'move':
      return [...placeOf(model), ...pace, toolSpeed, ...rest];
    case 'line':
      return [...placeOf(model), { ...toolSpeed, extra: false }, ...pace, ...rest];
    case 'arc':
      return [
        { id: 'via', slot: { key: 'via' }, kind: 'place', needed: true },
        ...placeOf(model),
        { ...toolSpeed, extra: false },
        ...pace,
        ...rest,
      ];
    case 'spline':
      return [{ id: 'points', slot: { at: 1 }, kind: 'words', needed: true }, toolSpeed, ...pace, ...rest];
    case 'jaws': {
      const upper = model.kind === 'serial' ? model.geometry.gripper?.width_max_m : undefined;
      return [
        { id: 'width', slot: { at: 1 }, kind: 'length', lower: 0, upper, needed: true },
        { id: 'holds', slot: { key: 'holds' }, kind: 'length', lower: 0, upper: 0.5, extra: true },
      ];
    }
    case 'gripper':
      return [{ id: 'angle', slot: { at: 1 }, kind: 'text', needed: true }];
    case 'suction':
      return [{ id: 'suction', slot: { at: 1 }, kind: 'choice', choices: ['on', 'release', 'off'], needed: true }];
    case 'nozzle':
      return [
        { id: 'angle', slot: { at: 1 }, kind: 'angle', lower: 0, upper: Math.PI, needed: true },
        { id: 'time', slot: { key: 'time' }, kind: 'time', needed: true },
      ];
    case 'wait':
      return [{ id: 'wait', slot: { at: 1 }, kind: 'words', needed: true }];
    case 'loop':
      return [{ id: 'count', slot: { at: 1 }, kind: 'count', lower: 1, needed: true }];
    case 'if':
      return [{ id: 'condition', slot: { at: 1 }, kind: 'text', needed: true }];
    case 'call':
      return [{ id: 'program', slot: { at: 1 }, kind: 'program', needed: true }];
    case 'pick':
    case 'repeat':
      return [
        { id: 'color', slot: { key: 'color' }, kind: 'choice', choices: kColors },
        ...(word === 'pick' ? [{ id: 'at', slot: { key: 'at' }, kind: 'place' } as const] : []),
      ];
    case 'place':
      return [{ id: 'into', slot: { at: 1 }, kind: 'into' }, ...placeOf(model).filter((one) => one.id !== 'to')];
    case 'look':
      return [{ id: 'camera', slot: { at: 1 }, kind: 'camera' }];
    case 'velocity':
    case 'acceleration': {
      const upper = model.robot === 'bigrobotarm' ? 3 : 1;
      const limit = { kind: 'share', lower: 0.01, upper } as const;
      const joints = model.joints.map((joint, i): Field => ({
        ...keyed(joint.name, 'share', limit),
        slot: { key: joint.name, also: `J${i + 1}` },
      }));
      return [keyed('all', 'share', limit), ...joints];
    }
    default:
      return [];
  }
}

/** Fields whose value stands in the row as words without a name before them. */
const isNamed = (field: Field): boolean => field.kind === 'words' || field.kind === 'into' || field.kind === 'camera';

/** All words that name neither the step nor a value: of `spline` its places, of `wait` what it waits for. */
const isPlain = (token: string): boolean => !token.includes('=') || /[<>]/.test(token);

export function readField(tokens: readonly string[], field: Field): string {
  if (isNamed(field)) return tokens.slice(1).filter(isPlain).join(' ');
  return readSlot(tokens, field.slot);
}

export type Complaint = 'needed' | 'number' | 'low' | 'high' | 'words';

export type Written = { raw: string } | { wrong: Complaint; limit?: number };

/** The row with another value in this field, or why that value is none. */
export function writeField(raw: string, field: Field, value: string): Written {
  const wish = value.trim();
  if (field.kind === 'words' && wish === '') return { wrong: 'needed' };
  if (isNamed(field)) return writeWords(raw, wish, field.kind === 'into');
  if (wish === '') return field.needed ? { wrong: 'needed' } : { raw: writeSlot(raw, field.slot, '') };
  const read = readValue(field, wish);
  return 'wrong' in read ? read : { raw: writeSlot(raw, field.slot, read.text) };
}

/** @param instead  of all else that says where */
function writeWords(raw: string, wish: string, instead: boolean): Written {
  if (/#/.test(wish)) return { wrong: 'words' };
  const code = raw.split('#')[0]!;
  const tokens = code.trim().split(/[ \t]+/);
  const others = tokens.slice(1).filter((one) => !isPlain(one) && !(instead && kGoal.test(one)));
  const remark = raw.includes('#') ? `  ${raw.slice(raw.indexOf('#'))}` : '';
  const indent = /^[ \t]*/.exec(code)![0];
  return { raw: `${indent}${[tokens[0], ...wish.split(/\s+/).filter(Boolean), ...others].join(' ')}${remark}` };
}

function readValue(field: Field, wish: string): { text: string } | { wrong: Complaint; limit?: number } {
  switch (field.kind) {
    case 'camera':
    case 'into':
    case 'point':
    case 'program':
    case 'choice':
    case 'words':
    case 'text':
      return /[\s#]/.test(wish) ? { wrong: 'words' } : { text: wish };
    case 'count':
      if (!/^\d+$/.test(wish)) return { wrong: 'number' };
      return Number(wish) < (field.lower ?? 0) ? { wrong: 'low', limit: field.lower } : { text: wish };
    case 'place': {
      if (/^[A-Za-z][\w-]*$/.test(wish)) return { text: wish };
      const parts = wish.split(/\s*[,;]\s*|\s+/).map((one) => readQuantity(one, 'length'));
      if (parts.length !== 3 || parts.some((one) => !one)) return { wrong: 'number' };
      return { text: parts.map((one) => one!.text).join(',') };
    }
    case 'blend': {
      const read = readQuantity(wish, 'length') ?? readQuantity(wish, 'angle');
      return read ? { text: read.text } : { wrong: 'number' };
    }
    default: {
      const read = readQuantity(wish, field.kind);
      if (!read) return { wrong: 'number' };
      if (field.lower !== undefined && read.value < field.lower - 1e-9) return { wrong: 'low', limit: field.lower };
      if (field.upper !== undefined && read.value > field.upper + 1e-9) return { wrong: 'high', limit: field.upper };
      return { text: read.text };
    }
  }
}

const kGoal = /^(?:to|frame|d?(?:[xyz]|r[xyz]|pitch|roll))=/;

/** The words of a row that say where it goes: names, places, differences, and in which frame. */
function isPlace(token: string, model: RobotModel): boolean {
  const key = /^([A-Za-z][\w.]*)=/.exec(token)?.[1];
  if (key === undefined) return false;
  const joint = key.replace(/^d\./, '');
  return (
    kGoal.test(token) ||
    /^J\d+$/i.test(joint) ||
    model.joints.some((one) => one.name === joint)
  );
}

/** The row, going to these joints or to where the tool is at them; what it says beside that stays. */
export function hereRow(raw: string, model: RobotModel, joints: readonly number[], tool: Pose): string {
  const { indent, body, remark } = splitLine(raw);
  const [word, ...rest] = body.split(/[ \t]+/) as [string, ...string[]];
  const place = word === 'joint' ? jointRow(model, joints).split(' ').slice(1) : toolWords(model, tool);
  const named = word === 'place' ? isPlain : () => false;
  const others = rest.filter((token) => !isPlace(token, model) && !named(token));
  return `${indent}${[word, ...place, ...others].join(' ')}${remark ? `  ${remark}` : ''}`;
}

/** Where the tool is. The attitude too where this page knows how the robot's rows write it. */
function toolWords(model: RobotModel, tool: Pose): string[] {
  const fine = model.kind === 'hexapod';
  const words = ['x', 'y', 'z'].map((axis, i) => `${axis}=${written(tool.p[i]!, 'length', fine ? 3 : 2)}`);
  const turns = fixedXyz(tool.q);
  if (model.task === 'yaw') return [...words, `rz=${written(turns[2], 'angle')}`];
  if (model.task !== 'pose') return words;
  return [...words, ...['rx', 'ry', 'rz'].map((axis, i) => `${axis}=${written(turns[i]!, 'angle', fine ? 3 : 2)}`)];
}

/** What a new step says until somebody changes it: the place where the robot is now. */
export function newRows(word: Word, model: RobotModel, joints: readonly number[], tool: Pose, program?: string, basket?: string): string[] {
  const at = (axis: 0 | 1 | 2): string => written(tool.p[axis], 'length', model.kind === 'hexapod' ? 3 : 1);
  const place = toolWords(model, tool).join(' ');
  switch (word) {
    case 'joint':
      return [jointRow(model, joints)];
    case 'move':
    case 'line':
      return [`${word} ${place}`];
    case 'arc':
      return [`arc via=${at(0)},${at(1)},${written(tool.p[2] + 0.01, 'length', 1)} ${place}`];
    case 'spline':
      return [`spline ${at(0)},${at(1)},${at(2)}`];
    case 'home':
      return ['home'];
    case 'jaws':
      return ['jaws 20mm'];
    case 'gripper':
      return ['gripper 40deg'];
    case 'suction':
      return ['suction on'];
    case 'nozzle':
      return ['nozzle 90deg time=1s'];
    case 'wait':
      return ['wait 1s'];
    case 'loop':
      return ['loop 2', 'end'];
    case 'if':
      return [`if ${model.joints[0]!.name}>${model.kind === 'hexapod' ? '250mm' : model.joints[0]!.kind === 'prismatic' ? '0mm' : '0deg'}`, 'else', 'end'];
    case 'call':
      return [`call ${program ?? 'NAME'}`];
    case 'look':
    case 'pick':
      return [word];
    case 'place':
      return [`place ${basket ?? place}`];
    case 'repeat':
      return ['repeat while seen', 'end'];
    case 'velocity':
    case 'acceleration':
      return [`${word} all=50%`];
  }
}
