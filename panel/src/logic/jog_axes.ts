/** What can be jogged or stepped in a frame, how fast, and which key does it. */
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
  const turns = { pose: ['rx', 'ry', 'rz'], yaw: ['rz'], approach: ['rx', 'ry', 'rz'], pitch_roll: ['pitch', 'roll'], point: [] };
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

/** Places of a tool's turns in a jog, by where a stick or the keys for X, Y and Z point. */
export function turnKeys(axes: readonly JogAxis[]): { across?: number; up?: number; about?: number } {
  const place = (...names: string[]): number | undefined => {
    const found = axes.findIndex((one) => names.includes(one.name));
    return found < 0 ? undefined : found;
  };
  return { across: place('rx', 'roll'), up: place('ry', 'pitch'), about: place('rz') };
}

/**
 * The usual set of machine controls: arrows for X and Y, page keys for Z, with Shift the turns that
 * this tool has; of joints the arrows move the chosen one.
 */
export function jogKey(
  key: string,
  shift: boolean,
  axes: readonly JogAxis[],
  frame: JogFrame,
  joint: number,
): KeyWish | null {
  if (frame === 'joint') {
    const sign = { ArrowRight: 1, ArrowLeft: -1, '=': 1, '+': 1, '-': -1 }[key] as 1 | -1 | undefined;
    return sign ? { axis: joint, sign } : null;
  }
  const { across, up, about } = shift ? turnKeys(axes) : { across: 0, up: 1, about: 2 };
  const wishes: Record<string, [number | undefined, 1 | -1]> = {
    ArrowRight: [across, 1],
    ArrowLeft: [across, -1],
    ArrowUp: [up, 1],
    ArrowDown: [up, -1],
    PageUp: [about, 1],
    PageDown: [about, -1],
  };
  const [axis, sign] = wishes[key] ?? [];
  return axis === undefined || !sign ? null : { axis, sign };
}
