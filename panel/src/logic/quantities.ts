/** Numbers of a program's row: each with its unit, kept as somebody wrote it. */
import type { RobotModel } from './types';
import { jointLimits } from './store';

export type Quantity = 'angle' | 'length' | 'time' | 'share' | 'speed' | 'accel' | 'turn_speed';

const kRad = Math.PI / 180;
/** What counts where no unit is said comes first. */
const kUnits: Record<Quantity, Record<string, number>> = {
  angle: { deg: kRad, rad: 1 },
  length: { mm: 1e-3, cm: 1e-2, m: 1, in: 0.0254 },
  time: { s: 1, ms: 1e-3, min: 60 },
  share: { '%': 0.01 },
  speed: { 'mm/s': 1e-3, 'm/s': 1 },
  accel: { 'mm/s2': 1e-3, 'm/s2': 1 },
  turn_speed: { 'deg/s': kRad, 'rad/s': 1 },
};

export const usualUnit = (quantity: Quantity): string => Object.keys(kUnits[quantity])[0]!;

export interface Reading {
  /** SI. */
  value: number;
  /** As a row has it: a point for the comma, the unit behind it. */
  text: string;
}

export function readQuantity(text: string, quantity: Quantity): Reading | null {
  const match = /^\s*([+-]?(?:\d+(?:[.,]\d*)?|[.,]\d+))\s*([a-z%°/0-9]*)\s*$/i.exec(text.replace('−', '-'));
  if (!match) return null;
  const number = match[1]!.replace(',', '.');
  const unit = match[2] === '' ? usualUnit(quantity) : match[2] === '°' ? 'deg' : match[2]!.toLowerCase();
  const factor = kUnits[quantity][unit];
  const value = Number(number);
  if (factor === undefined || !Number.isFinite(value)) return null;
  return { value: value * factor, text: number + unit };
}

/** SI as a row says it; mm and degrees, as many digits as count. */
export function written(value: number, quantity: 'angle' | 'length', digits = 2): string {
  const factor = kUnits[quantity][usualUnit(quantity)]!;
  const number = Number((value / factor).toFixed(digits));
  return `${Object.is(number, -0) ? 0 : number}${usualUnit(quantity)}`;
}

/** A `joint` row that names every joint. */
export function jointRow(model: RobotModel, joints: readonly number[], digits = 2): string {
  const words = model.joints.map((joint, i) => {
    const { measure } = jointLimits(joint);
    return `${joint.name}=${written(joints[i] ?? 0, measure, measure === 'length' ? digits + 1 : digits)}`;
  });
  return ['joint', ...words].join(' ');
}
