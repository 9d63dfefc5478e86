/**
 * Homing, recovery and commissioning as the page shows them: what the server tells in `procedure`
 * messages, read for people, and their answers checked before they are sent. The server checks again.
 */
import { parseQuantity, shown, unitOf, type Measure } from './units';

export type ProcedureKind = 'home' | 'recover' | 'commission';
export const kProcedures: readonly ProcedureKind[] = ['home', 'recover', 'commission'];

export type ProcedurePhase =
  | 'opening'
  | 'asking'
  | 'working'
  | 'cancelling'
  | 'done'
  | 'cancelled'
  | 'failed';

export type AskKind = 'yes' | 'go' | 'words' | 'number' | 'amount' | 'place';

export interface AsksJson {
  kind: AskKind;
  words: string;
  choices: string[];
  ready: boolean;
  lower_m?: number;
  upper_m?: number;
  lower_rad?: number;
  upper_rad?: number;
  lower?: number;
  upper?: number;
}

export interface ProgressJson {
  words: string;
  elapsed_s: number;
  at_most_s?: number;
  share?: number;
}

export interface ProcedureStepJson {
  step: string;
  text: string;
  state: 'open' | 'done' | 'skipped' | 'failed';
  answer?: string;
  words?: string;
  number?: number;
}

export interface ProcedureJson {
  robot: string;
  /** 0: there was none yet. */
  number: number;
  client: number;
  kind: ProcedureKind | '';
  title: string;
  phase: ProcedurePhase;
  over: boolean;
  answers: number;
  place: number;
  step?: { id: string; number: number; of: number; text: string };
  asks?: AsksJson;
  /** Its client is gone: it waits at its step for the next one. */
  client_lost?: boolean;
  joint?: string;
  progress?: ProgressJson;
  trouble?: string;
  steps: ProcedureStepJson[];
  file?: string;
  settings?: Record<string, string>;
  note?: string;
}

export type StepLook = ProcedureStepJson['state'] | 'now';

/** Each step as the list shows it: the one under way stands out, whatever was answered of it before. */
export function stepLook(procedure: ProcedureJson, index: number): StepLook {
  const step = procedure.steps[index];
  if (!step) return 'open';
  return !procedure.over && index === procedure.place ? 'now' : step.state;
}

/** `direction.base`: what kind of step, and of which joint; a step without one is its own kind. */
export function stepName(id: string): { key: string; joint: string } {
  const dot = id.indexOf('.');
  return dot < 0 ? { key: id, joint: '' } : { key: id.slice(0, dot), joint: id.slice(dot + 1) };
}

/** Share of the list that is behind it, 0 to 1. */
export function shareDone(procedure: ProcedureJson): number {
  if (procedure.steps.length === 0) return 0;
  if (procedure.phase === 'done') return 1;
  return Math.min(1, procedure.place / procedure.steps.length);
}

export interface Left {
  /** s */
  seconds: number;
  /** It may take so long; it will hardly. */
  atMost: boolean;
  /** 0 to 1 */
  share: number;
}

/**
 * How long what goes on will go on, in our time; nothing where nobody can tell yet.
 * @param timeScale  how much faster the robot's own time runs, in which it is told
 */
export function timeLeft(progress: ProgressJson | undefined, timeScale = 1): Left | null {
  if (!progress) return null;
  const { elapsed_s: elapsed, at_most_s: atMost, share } = progress;
  if (atMost !== undefined && atMost > 0) {
    return {
      seconds: Math.max(0, atMost - elapsed) / timeScale,
      atMost: true,
      share: Math.min(1, Math.max(0, elapsed / atMost)),
    };
  }
  if (share === undefined || share <= 0.01 || elapsed <= 0) return null;
  return { seconds: Math.max(0, elapsed / share - elapsed) / timeScale, atMost: false, share: Math.min(1, share) };
}

/** Ended by this page's own end (a reload, a lost connection), and not by anybody's wish. */
export function wasCutOff(procedure: ProcedureJson | undefined, wished: boolean): boolean {
  if (!procedure || procedure.number === 0 || !procedure.over) return false;
  return !wished && (procedure.phase === 'cancelled' || procedure.phase === 'failed');
}

export type Checked = { answer: string } | { wrong: 'empty' | 'number' | 'range' | 'whole'; low?: string; high?: string };

export interface Range {
  measure: Measure | null;
  lower: number;
  upper: number;
}

export function rangeOf(asks: AsksJson): Range | null {
  if (asks.lower_m !== undefined && asks.upper_m !== undefined) {
    return { measure: 'length', lower: asks.lower_m, upper: asks.upper_m };
  }
  if (asks.lower_rad !== undefined && asks.upper_rad !== undefined) {
    return { measure: 'angle', lower: asks.lower_rad, upper: asks.upper_rad };
  }
  if (asks.lower !== undefined && asks.upper !== undefined) {
    return { measure: null, lower: asks.lower, upper: asks.upper };
  }
  return null;
}

const kUnit: Record<Measure, string> = { length: 'mm', angle: 'deg' };
const inUsual = (value: number, measure: Measure): string => {
  const number = measure === 'length' ? value * 1e3 : (value * 180) / Math.PI;
  return `${Number(number.toPrecision(9))}${kUnit[measure]}`;
};

/** A number that is asked for, as the server reads it: always with its unit. */
export function checkNumber(text: string, range: Range): Checked {
  if (text.trim() === '') return { wrong: 'empty' };
  if (range.measure === null) {
    if (!/^\s*\d+\s*$/.test(text)) return { wrong: 'whole' };
    const value = Number(text);
    const [low, high] = [String(range.lower), String(range.upper)];
    return value < range.lower || value > range.upper ? { wrong: 'range', low, high } : { answer: String(value) };
  }
  const value = parseQuantity(text, range.measure);
  if (value === null) return { wrong: 'number' };
  const end = (one: number) => `${shown(one, range.measure!)} ${unitOf(range.measure!)}`;
  const slack = 1e-9 * Math.max(Math.abs(range.lower), Math.abs(range.upper));
  if (value < range.lower - slack || value > range.upper + slack) {
    return { wrong: 'range', low: end(range.lower), high: end(range.upper) };
  }
  return { answer: inUsual(value, range.measure) };
}

/** By how much a joint goes by hand, at most so far at a time, either way. */
export const kAmountMax: Record<Measure, number> = { length: 0.01, angle: (20 * Math.PI) / 180 };

export function checkAmount(text: string, measure: Measure): Checked {
  const most = kAmountMax[measure];
  const checked = checkNumber(text, { measure, lower: -most, upper: most });
  return 'answer' in checked && parseFloat(checked.answer) === 0 ? { wrong: 'number' } : checked;
}

/** Where it stands: one of the names, or a value a joint; and why, where it was moved by hand. */
export function checkPlace(values: string[], measures: readonly Measure[], moved: string): Checked {
  const answers: string[] = [];
  for (const [i, text] of values.entries()) {
    const measure = measures[i] ?? 'angle';
    const value = text.trim() === '' ? null : parseQuantity(text, measure);
    if (value === null) return { wrong: text.trim() === '' ? 'empty' : 'number' };
    answers.push(inUsual(value, measure));
  }
  return { answer: withReason(answers.join(','), moved) };
}

export function withReason(place: string, moved: string): string {
  const reason = moved.replaceAll(/\s+/g, ' ').trim();
  return reason === '' ? place : `${place} moved: ${reason}`;
}

/** Steps for hands: small, middle, large; each way. The answer is its text. */
export const kAmounts: Record<Measure, readonly string[]> = {
  length: ['0.1mm', '0.5mm', '2mm'],
  angle: ['0.5deg', '2deg', '10deg'],
};
