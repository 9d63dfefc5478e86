import { signal } from '@preact/signals';
import { sentenceIn, type ErrorWords, type Told } from '../logic/sentence';
import { complaintReader, type ComplaintReader } from './complaints';
import { calibrationSentencesDe } from './calibration_de';
import { complaintsDe } from './complaints_de';
import { de } from './de';
import { en, type Key } from './en';
import { errorsDe } from './errors_de';

interface Words {
  name: string;
  texts: Readonly<Record<Key, string>>;
  /** For the server's errors; without: its own words, which are English. */
  errors?: ErrorWords;
  /** For what it complains of in a text. */
  complaints?: ComplaintReader;
}

const programsDe = complaintReader(complaintsDe);
const calibrationsDe = complaintReader(calibrationSentencesDe);

/** A language is a file and a row here. */
export const kLanguages = {
  en: { name: 'English', texts: en },
  de: { name: 'Deutsch', texts: de, errors: errorsDe, complaints: (text) => programsDe(text) ?? calibrationsDe(text) },
} satisfies Record<string, Words>;
export type Language = keyof typeof kLanguages;

export const language = signal<Language>('en');

export function preferredLanguage(kept: string | null, browser: readonly string[]): Language {
  for (const wish of [kept, ...browser]) {
    const code = wish?.slice(0, 2).toLowerCase();
    if (code && code in kLanguages) return code as Language;
  }
  return 'en';
}

/** The text of a key in the language at hand. */
export function t(key: Key, values: Record<string, string | number> = {}): string {
  const text: string = kLanguages[language.value].texts[key];
  return text.replace(/\{(\w+)\}/g, (_, name: string) => String(values[name] ?? ''));
}

/** Of a name that came over the wire; the name itself where this page does not know it. */
export function tWord(prefix: string, word: string, values: Record<string, string | number> = {}): string {
  const key = `${prefix}.${word}`;
  return key in en ? t(key as Key, values) : word.replaceAll('_', ' ');
}

/** An error of the server in the language at hand. */
export function errorSentence(error: Told): string {
  const words: Words = kLanguages[language.value];
  return sentenceIn(words.errors, error);
}

/** What the server complains of in a text, in the language at hand; its own words where they are not known here. */
export function complaintSentence(text: string): string {
  const words: Words = kLanguages[language.value];
  return words.complaints?.(text) ?? text;
}

/** A complaint with its place, as a refusal brings it along. */
interface Complained {
  file: string;
  line: number;
  column: number;
  sentence: string;
}
/** What the server calls a text that was not opened by a name. */
const kNoFile = ['program', 'the file'];

/** @param message  the server's own words: place, sometimes whom it is about, and sentence */
function placedComplaint(message: string, { file, line, column, sentence }: Complained): string {
  const said = complaintSentence(sentence);
  if (said === sentence) return message;
  const place = `${file}:${line}:${column}: `;
  const whom = message.startsWith(place) ? message.slice(place.length, -sentence.length) : '';
  if (kNoFile.includes(file)) return `${t('prog.in_row', { line })}: ${whom}${said}`;
  return t('prog.row.in', { file, line, text: whom + said });
}

/** .. or whatever it was that an answer refused with: its data where that says more than its words. */
export function refusalSentence(error: { message: string; data?: unknown }): string {
  const data = ((typeof error.data === 'object' && error.data) || {}) as Told & { cause?: string; complaints?: Complained[] };
  if (data.code) return errorSentence({ ...data, sentence: error.message });
  if (data.cause) return t('events.stop', { cause: tWord('cause', data.cause) });
  const first = data.complaints?.[0];
  return first ? placedComplaint(error.message, first) : complaintSentence(error.message);
}

export type { Key };
