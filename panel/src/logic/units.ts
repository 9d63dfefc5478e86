/** People read mm and degrees and may type any unit; inside all is SI and radians. */
import { signal } from '@preact/signals';

export type Measure = 'length' | 'angle';

export const toDeg = (rad: number): number => (rad * 180) / Math.PI;
export const toRad = (deg: number): number => (deg * Math.PI) / 180;
export const toMm = (m: number): number => m * 1e3;

const kUnits: Record<Measure, Record<string, number>> = {
  length: { mm: 1e-3, cm: 1e-2, m: 1, in: 0.0254, '"': 0.0254 },
  angle: { deg: Math.PI / 180, '°': Math.PI / 180, rad: 1, turn: 2 * Math.PI },
};
const kUsual: Record<Measure, string> = { length: 'mm', angle: 'deg' };

/** "90deg", "1.2in", "-3,5": the number in SI; mm and degrees where no unit is said. */
export function parseQuantity(text: string, measure: Measure): number | null {
  const match = /^\s*([+-]?(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:[eE][+-]?\d+)?)\s*([a-zA-Z"°]*)\s*$/.exec(
    text.replace('−', '-'),
  );
  if (!match) return null;
  const unit = match[2] === '' ? kUsual[measure] : match[2]!.toLowerCase();
  const factor = kUnits[measure][unit];
  const value = Number(match[1]!.replace(',', '.'));
  return factor === undefined || !Number.isFinite(value) ? null : value * factor;
}

/** As the language at hand writes numbers. */
export const decimalMark = signal<'.' | ','>('.');

/** So many decimals; a true minus sign, and no minus before nothing. */
export function decimals(value: number, digits: number): string {
  const text = value.toFixed(digits);
  const plain = Number(text) === 0 ? (0).toFixed(digits) : text.replace('-', '−');
  return plain.replace('.', decimalMark.value);
}

/** The value as people read it, in mm or degrees, without its unit. */
export function shown(value: number, measure: Measure, digits = 1): string {
  return decimals(measure === 'angle' ? toDeg(value) : toMm(value), digits);
}

export const unitOf = (measure: Measure): string => (measure === 'angle' ? '°' : 'mm');

/** "0.4 s", "12.3 s", "2 min 05 s", "1 h 04 min". */
export function duration(seconds: number): string {
  if (seconds < 60) return `${decimals(seconds, seconds < 10 ? 2 : 1)} s`;
  const whole = Math.round(seconds);
  if (whole < 3600) return `${Math.floor(whole / 60)} min ${String(whole % 60).padStart(2, '0')} s`;
  const minutes = Math.round(seconds / 60);
  return `${Math.floor(minutes / 60)} h ${String(minutes % 60).padStart(2, '0')} min`;
}

const brief = (seconds: number): string => (seconds < 60 ? `${decimals(seconds, 1)} s` : duration(seconds));

/** How long something takes: "1.4 s", "≤ 2.0 s" where it may take no time, "3.0 s – 5.5 s". */
export function timeSpan(least: number, most: number): string {
  if (most - least < 0.05) return brief(most);
  return least < 0.05 ? `≤ ${brief(most)}` : `${brief(least)} – ${brief(most)}`;
}

/** Of what was a while ago: nobody needs tenths then. */
export const age = (seconds: number): string => (seconds < 60 ? `${seconds} s` : duration(seconds));

export const clamp = (value: number, low: number, high: number): number =>
  Math.min(high, Math.max(low, value));
