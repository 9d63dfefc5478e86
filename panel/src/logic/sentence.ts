/**
 * What the server says of an error, in another language than its own. It tells a code, whom it is about and two
 * numbers beside its English sentence; a language has a sentence a code. Where anything is missing, the English one
 * stays: it is always right.
 */
import type { ErrorJson } from './types';
import { duration, shown, toDeg, toMm, unitOf } from './units';

/** A language's words for errors. `{name}` is filled in. */
export interface ErrorWords {
  /** By code: {subject} {device} {measured} {limit} {excess} {dz}, and {sentence}, the server's own. */
  codes: Readonly<Record<string, string>>;
  /** A joint whose board is left out: {subject}. */
  leftOut: string;
  /** The same where bodies overlap, by {overlap}. */
  overlaps: Readonly<Record<string, string>>;
  /** Whose answer is meant: the device's, or where there are several boards that of one. */
  device: { one: string; of: string };
  /** Between two names. */
  and: string;
  /** What stands in a robot's way in its cell: parts of one sentence. */
  inCell: Record<
    'askerUnknown' | 'unknown' | 'overlap' | 'near' | 'tooNear' | 'begins' | 'onTheWay' | 'whole' | 'object' | 'rests' | 'moves',
    string
  >;
}

/** The data of a refusal: an error, or parts of one. */
export type Told = Partial<ErrorJson>;

const kUnits = ['', '_m', '_rad', '_s', '_v', '_rad_s', '_rad_s2'] as const;
type Unit = (typeof kUnits)[number];

export function sentenceIn(words: ErrorWords | undefined, error: Told): string {
  const said = error.sentence ?? '';
  if (!words || !error.code) return said;
  const inCell = error.code === 'cell_contact' || error.code === 'cell_taken';
  if (inCell && error.other !== undefined) return inCellSentence(words, error) ?? said;
  const overlaps = (numberOf(error, 'measured_m') ?? 0) < 0;
  const template = error.left_out ? words.leftOut : (overlaps && words.overlaps[error.code]) || words.codes[error.code];
  return (template && filled(template, valuesOf(words, error))) ?? said;
}

/** Nothing where a value is not known. */
function filled(template: string, values: Readonly<Record<string, string | undefined>>): string | undefined {
  let whole = true;
  const text = template.replace(/\{(\w+)\}/g, (_, name: string) => {
    if (!values[name]) whole = false;
    return values[name] ?? '';
  });
  return whole ? text : undefined;
}

function valuesOf(words: ErrorWords, error: Told): Record<string, string | undefined> {
  const subject = error.joint ?? error.link ?? error.links?.replace(' and ', ` ${words.and} `);
  const unit = kUnits.find((one) => `measured${one}` in error || `limit${one}` in error) ?? '';
  const measured = numberOf(error, `measured${unit}`);
  const limit = numberOf(error, `limit${unit}`);
  const excess = measured !== undefined && limit !== undefined ? Math.abs(measured - limit) : undefined;
  const text = (value: number | undefined) => (value === undefined ? undefined : valueText(value, unit, excess));
  return {
    subject,
    device: subject === undefined ? words.device.one : filled(words.device.of, { subject }),
    measured: text(measured),
    limit: text(limit),
    excess: text(excess),
    overlap: measured !== undefined ? text(-measured) : undefined,
    dz: limit !== undefined ? `dz=-${Math.ceil(toMm(limit) * 10 - 1e-6) / 10}mm` : undefined,
    sentence: error.sentence,
  };
}

const numberOf = (error: Told, name: string): number | undefined => {
  const value = (error as Record<string, unknown>)[name];
  return typeof value === 'number' && Number.isFinite(value) ? value : undefined;
};

/** @param excess  what counts is how far the numbers are apart: so many places as show that */
function valueText(value: number, unit: Unit, excess?: number): string {
  switch (unit) {
    case '_m':
    case '_rad': {
      const measure = unit === '_m' ? 'length' : 'angle';
      const apart = excess === undefined ? 1 : unit === '_m' ? toMm(excess) : toDeg(excess);
      return `${trimmed(shown(value, measure, placesFor(apart)))}${unit === '_m' ? ' ' : ''}${unitOf(measure)}`;
    }
    case '_s':
      return value < 60 ? `${few(value)} s` : duration(value);
    case '_v':
      return `${few(value)} V`;
    case '_rad_s':
      return `${trimmed(shown(value, 'angle'))}°/s`;
    case '_rad_s2':
      return `${trimmed(shown(value, 'angle'))}°/s²`;
    case '':
      return few(value);
  }
}

const placesFor = (apart: number): number =>
  apart >= 1 || apart < 1e-9 ? 1 : Math.min(6, Math.ceil(-Math.log10(apart)) + 1);
const trimmed = (text: string): string => (text.includes('.') ? text.replace(/\.?0+$/, '') : text);
const few = (value: number): string =>
  String(Number.isInteger(value) ? value : Number(value.toPrecision(3))).replace('-', '−');

/** The server says these two in its sentence only. */
export const kAskerUnknown = 'nobody knows where this robot is';
export const kOtherUnknown = 'nobody knows where that one is';

function inCellSentence(words: ErrorWords, error: Told): string | undefined {
  const { link, other = '', other_link, sentence = '', share = 0, moving } = error;
  const parts = words.inCell;
  const whom = other_link ? `${other} (${other_link})` : other;
  if (sentence.startsWith(kAskerUnknown)) return filled(parts.askerUnknown, { other });
  if (sentence.includes(kOtherUnknown)) return filled(parts.unknown, { link, whom });
  const mm = (name: string): string | undefined => {
    const value = numberOf(error, name);
    return value === undefined ? undefined : `${Math.round(toMm(Math.abs(value)))} mm`;
  };
  const distance = mm('distance_m');
  const overlaps = (numberOf(error, 'distance_m') ?? 0) < 0;
  const how = filled(distance === undefined ? parts.tooNear : overlaps ? parts.overlap : parts.near, { link, whom, distance });
  const where =
    share > 0 ? filled(parts.onTheWay, { percent: String(Math.round(100 * share)), way: mm('way_m') }) : parts.begins;
  const then = filled(!other_link ? parts.object : moving ? parts.moves : parts.rests, { other });
  return filled(parts.whole, { how, where, margin: mm('margin_m'), then });
}
