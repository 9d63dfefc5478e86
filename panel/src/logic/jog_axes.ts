/** What can be jogged or stepped in a frame, how fast, and which key or stick does it. */
import { jointLimits } from './store';
import type { JogFrame, RobotModel } from './types';
import { toDeg, toMm, type Measure } from './units';

export interface JogAxis {
  /** "base", "x", "rx", "pitch": as rows of a program call it. */
  name: string;
  measure: Measure;
  /** rad/s or m/s at full speed. */
  speed: number;
}

/** Faster by hand than anybody looks. m/s and rad/s. */
const kLinear = { serial: 0.2, palletizer: 0.15, hexapod: 0.03 } as const;
const kAngular = { serial: 0.8, palletizer: 0.8, hexapod: 0.3 } as const;

export function jogAxes(model: RobotModel, frame: JogFrame): JogAxis[] {
  if (frame === 'joint') {
    return model.joints.map((joint) => {
      const { measure, velocity } = jointLimits(joint);
      return { name: joint.name, measure, speed: velocity };
    });
  }
  const lengths: JogAxis[] = ['x', 'y', 'z'].map((name) => ({
    name,
    measure: 'length',
    speed: kLinear[model.kind],
  }));
  const turns = { pose: ['rx', 'ry', 'rz'], approach: ['rx', 'ry', 'rz'], pitch_roll: ['pitch', 'roll'], point: [] };
  const angles: JogAxis[] = turns[model.task].map((name) => ({
    name,
    measure: 'angle',
    speed: kAngular[model.kind],
  }));
  // A jog has as many numbers as the server says.
  return [...lengths, ...angles].slice(0, model.jog[frame] ?? 6);
}

/** Frames to choose from: those of a jog, or where only whole moves are taken those of a step. */
export function jogFrames(model: RobotModel): JogFrame[] {
  const held = Object.keys(model.jog) as JogFrame[];
  if (held.length > 0) return held;
  return model.task === 'point' ? ['joint', 'base'] : ['joint', 'base', 'tool'];
}

const number = (value: number): string => String(Number(value.toFixed(6)));

/** A step as a row of a program, from where the robot is. */
export function stepRow(
  model: RobotModel,
  frame: JogFrame,
  axis: JogAxis,
  way: number,
  speed: number,
): string {
  const unit = axis.measure === 'angle' ? 'deg' : 'mm';
  const value = number(axis.measure === 'angle' ? toDeg(way) : toMm(way));
  const pace = model.takes_speed && speed < 1 ? ` speed=${number(Math.max(1, Math.round(100 * speed)))}%` : '';
  if (frame === 'joint') return `joint d.${axis.name}=${value}${unit}${pace}`;
  const along = frame === 'base' ? '' : 'frame=tool ';
  return `line ${along}d${axis.name}=${value}${unit}${pace}`;
}

export interface KeyWish {
  axis: number;
  sign: 1 | -1;
}

/**
 * The usual set of machine controls: arrows for X and Y, page keys for Z; of joints the arrows
 * move the chosen one.
 */
export function jogKey(key: string, frame: JogFrame, joint: number): KeyWish | null {
  if (frame === 'joint') {
    const sign = { ArrowRight: 1, ArrowLeft: -1, '=': 1, '+': 1, '-': -1 }[key] as 1 | -1 | undefined;
    return sign ? { axis: joint, sign } : null;
  }
  const wishes: Record<string, KeyWish> = {
    ArrowRight: { axis: 0, sign: 1 },
    ArrowLeft: { axis: 0, sign: -1 },
    ArrowUp: { axis: 1, sign: 1 },
    ArrowDown: { axis: 1, sign: -1 },
    PageUp: { axis: 2, sign: 1 },
    PageDown: { axis: 2, sign: -1 },
  };
  return wishes[key] ?? null;
}

export interface Pad {
  axes: readonly number[];
  buttons: readonly { pressed: boolean }[];
}

const kDead = 0.16;

/** Beyond the dead zone from 0, finer near it. */
export function stick(value: number): number {
  const beyond = Math.abs(value) - kDead;
  if (!(beyond > 0)) return 0;
  return Math.sign(value) * Math.min(1, beyond / (1 - kDead)) ** 1.6;
}

/**
 * What a standard gamepad asks for, as shares of full speed; nothing without a shoulder button
 * held (the dead man's switch) or with both sticks in the middle.
 */
export function padShares(pad: Pad, frame: JogFrame, joint: number, count: number): number[] | null {
  const held = (pad.buttons[4]?.pressed ?? false) || (pad.buttons[5]?.pressed ?? false);
  if (!held) return null;
  const [lx = 0, ly = 0, rx = 0, ry = 0] = pad.axes;
  const shares = new Array<number>(count).fill(0);
  if (frame === 'joint') shares[joint] = stick(lx);
  else {
    const wished = [stick(lx), stick(-ly), stick(-ry), 0, 0, stick(-rx)];
    shares.forEach((_, i) => (shares[i] = wished[i] ?? 0));
    if (count === 5) shares[4] = stick(-rx);
  }
  return shares.some((one) => one !== 0) ? shares : null;
}
