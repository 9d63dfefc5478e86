/**
 * What this browser keeps of programs and points, for each kind of robot: what is open, and what the
 * controller does not have (yet). The rest lies with the controller (logic/kept.ts).
 */
import type { Point } from './points';

export interface Kept {
  getItem(key: string): string | null;
  setItem(key: string, value: string): void;
}

export interface Draft {
  name: string;
  text: string;
  /** Of the kept text that it was made from; nothing: of none. */
  revision?: number;
}

export interface Shelf {
  programs: Record<string, string>;
  points: Point[];
  /** What is open, saved or not. */
  draft: Draft;
}

export const kProgramName = /^[A-Za-z][A-Za-z0-9_-]{0,39}$/;
const kKey = 'sinew.shelf.';

const empty = (): Shelf => ({ programs: {}, points: [], draft: { name: '', text: '' } });

/** What cannot be read is left where it is and not shown: a shelf is never emptied by a look. */
export function loadShelf(kept: Kept, robot: string): Shelf {
  try {
    const read = JSON.parse(kept.getItem(kKey + robot) ?? '{}') as Partial<Shelf>;
    const shelf = empty();
    for (const [name, text] of Object.entries(read.programs ?? {})) {
      if (kProgramName.test(name) && typeof text === 'string') shelf.programs[name] = text;
    }
    if (Array.isArray(read.points)) {
      shelf.points = read.points.filter((one) => typeof one?.name === 'string' && (Array.isArray(one.joints) || !!one.place));
    }
    if (typeof read.draft?.text === 'string') {
      const { name, text, revision } = read.draft;
      shelf.draft = { name: String(name ?? ''), text, ...(typeof revision === 'number' ? { revision } : {}) };
    }
    return shelf;
  } catch {
    return empty();
  }
}

/** @return  whether it is kept: a browser may have no room, or refuse. */
export function keepShelf(kept: Kept, robot: string, shelf: Shelf): boolean {
  try {
    kept.setItem(kKey + robot, JSON.stringify(shelf));
    return true;
  } catch {
    return false;
  }
}

/** Forms of other programs: the controller makes rows of them, and of rows the first two. */
export type TextForm = 'sequence' | 'pos' | 'gcode';
export type FileKind = 'program' | 'points' | 'foreign' | 'unknown' | TextForm;

const kForms: Record<TextForm, readonly string[]> = {
  sequence: ['txt'],
  pos: ['pos'],
  gcode: ['gcode', 'nc', 'ngc', 'tap', 'g'],
};

/** What a file is by its name; of foreign ones `sinew convert` knows what to do. */
export function fileKind(name: string): FileKind {
  const end = /\.([^.]+)$/.exec(name.toLowerCase())?.[1] ?? '';
  if (end === 'sinew') return 'program';
  if (end === 'toml') return 'points';
  const form = (Object.keys(kForms) as TextForm[]).find((one) => kForms[one].includes(end));
  return form ?? (['cfg', 'mcap'].includes(end) ? 'foreign' : 'unknown');
}

/** A text file's words: UTF-16 where it says so, as old programs on Windows write it. */
export function decoded(bytes: Uint8Array): string {
  const [first, second] = bytes;
  const wide = (first === 0xff && second === 0xfe && 'utf-16le') || (first === 0xfe && second === 0xff && 'utf-16be');
  return new TextDecoder(wide || 'utf-8').decode(bytes);
}

/** A file's name without its folder and ending, as a program's name. */
export function nameOfFile(file: string): string {
  const stem = file.replace(/^.*[\\/]/, '').replace(/\.[^.]*$/, '');
  const name = stem.replace(/[^A-Za-z0-9_-]+/g, '_').replace(/^[^A-Za-z]+/, '').slice(0, 40);
  return name === '' ? 'program' : name;
}
