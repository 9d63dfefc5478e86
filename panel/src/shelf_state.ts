/**
 * Programs and points of the kind of robot that is chosen: what the controller keeps, and what is in this
 * browser only. What is saved stands in the browser until the controller has said that it has it.
 */
import { batch, computed, effect, signal, untracked } from '@preact/signals';
import { model, robot, rpc, status, store } from './app';
import { changePoints, fetchKept, merged, notKept, onlyHere, saveProgram, type Kept, type NotKept, type PointChange } from './logic/kept';
import { freeName, type Point } from './logic/points';
import { keepShelf, loadShelf, type Draft, type Shelf } from './logic/shelf';
import { jointLimits } from './logic/store';
import { t } from './i18n';
import type { RobotModel } from './logic/types';
import type { Measure } from './logic/units';

const none: Shelf = { programs: {}, points: [], draft: { name: '', text: '' } };
const local = signal<Shelf>(none);
/** Null: the controller has not told yet. */
const controller = signal<Kept | null>(null);
export const shelf = computed(() => merged(local.value, controller.value));
/** On its way to the controller: names of programs and points. */
const sending = signal<readonly string[]>([]);
export const here = computed(() => {
  const { programs, points } = onlyHere(local.value, controller.value);
  const stays = (name: string) => !sending.value.includes(name);
  return {
    programs: Object.fromEntries(Object.entries(programs).filter(([name]) => stays(name))),
    points: points.filter((one) => stays(one.name)),
  };
});
async function whileSending<T>(names: readonly string[], work: () => Promise<T>): Promise<T> {
  sending.value = [...sending.peek(), ...names];
  try {
    return await work();
  } finally {
    const rest = [...sending.peek()];
    for (const name of names) rest.splice(rest.indexOf(name), 1);
    sending.value = rest;
  }
}
/** Whether this browser keeps what it is given. */
export const keeps = signal(true);
/** A program that somebody else has changed or removed (revision 0) since it was opened here. */
export const clash = signal<{ name: string; text: string; revision: number } | null>(null);
/** Why the controller did not keep something; empty: it did. */
export const trouble = signal('');
/** What is in this browser only stays there: not asked again before the page is loaded anew. */
export const leftHere = signal(false);

/** What kind of robot all of this is for: `learm`, whatever its name in the cell. */
export const kind = computed(() => model.value?.robot ?? null);
export const measuresOf = (one: RobotModel): Measure[] => one.joints.map((joint) => jointLimits(joint).measure);

function putLocal(next: Partial<Shelf>): void {
  const now = kind.peek();
  local.value = { ...local.peek(), ...next };
  if (now) keeps.value = keepShelf(localStorage, now, local.peek());
}
export const putDraft = (draft: Draft): void => putLocal({ draft });

function without<T>(all: Record<string, T>, name: string): Record<string, T> {
  const { [name]: _, ...rest } = all;
  return rest;
}

const sentence = (why: NotKept, name: string): string =>
  why.why === 'refused' ? why.sentence : t(why.why === 'conflict' ? 'kept.changed' : 'kept.lost', { name });

// --- What the controller keeps.
let asked = 0;
async function refresh(): Promise<void> {
  const name = robot.peek();
  const one = kind.peek();
  const turn = ++asked;
  if (!name || !one) return;
  try {
    const told = await fetchKept(rpc, name, controller.peek());
    if (turn === asked && kind.peek() === one) take(told);
  } catch (error) {
    if (turn !== asked) return;
    const why = notKept(error);
    if (why.why === 'refused') trouble.value = why.sentence;
    // A busy controller is asked again; where the connection is gone the next one asks.
    else setTimeout(() => turn === asked && store.connection.peek() === 'open' && void refresh(), 1000);
  }
}

/** What is open and was not changed here follows; copies of what the controller has are let go of. */
function take(told: Kept): void {
  const before = controller.peek();
  const { draft, programs, points } = local.peek();
  const theirs = told.programs[draft.name];
  const untouched = draft.text === before?.programs[draft.name]?.text;
  const follows = theirs && untouched && theirs.revision !== draft.revision;
  batch(() => {
    controller.value = told;
    putLocal({
      draft: follows ? { name: draft.name, text: theirs.text, revision: theirs.revision } : draft,
      programs: Object.fromEntries(Object.entries(programs).filter(([name, text]) => told.programs[name]?.text !== text)),
      points: points.filter((one) => !told.points.some((other) => JSON.stringify(other.joints) === JSON.stringify(one.joints) && other.name === one.name && !!one.joints)),
    });
  });
}

const watched = computed(() => (store.connection.value === 'open' ? `${kind.value} ${status.value?.kept ?? ''}` : ''));
let shownKind: string | null = null;
effect(() => {
  const now = kind.value;
  if (now === shownKind) return;
  shownKind = now;
  batch(() => {
    controller.value = null;
    clash.value = null;
    trouble.value = '';
    leftHere.value = false;
    local.value = now ? loadShelf(localStorage, now) : none;
  });
});
effect(() => {
  if (watched.value !== '') untracked(() => void refresh());
});

// --- Programs.
/**
 * @param revision  of what it was made from; 0: of nothing
 * @return  whether the controller has it now
 */
export async function keepProgram(name: string, text: string, revision: number): Promise<boolean> {
  const who = robot.peek();
  const one = kind.peek();
  putLocal({ programs: { ...local.peek().programs, [name]: text } });
  if (!who) return false;
  return whileSending([name], () => keepNow(who, one, name, text, revision));
}
async function keepNow(who: string, one: string | null, name: string, text: string, revision: number): Promise<boolean> {
  const saved = await saveProgram(rpc, who, name, text, revision);
  if (kind.peek() !== one) return !('why' in saved);
  if ('why' in saved) {
    batch(() => {
      if (saved.why === 'conflict') clash.value = { name, text, revision: saved.revision };
      else trouble.value = sentence(saved, name);
    });
    return false;
  }
  batch(() => {
    trouble.value = '';
    if (clash.peek()?.name === name) clash.value = null;
    const now = controller.peek();
    if (now) controller.value = { ...now, programs: { ...now.programs, [name]: saved } };
    const { draft, programs } = local.peek();
    putLocal({
      programs: without(programs, name),
      draft: draft.name === name ? { ...draft, revision: saved.revision } : draft,
    });
  });
  return true;
}
export const revisionOf = (name: string): number => controller.peek()?.programs[name]?.revision ?? 0;

export async function dropProgram(name: string): Promise<void> {
  const who = robot.peek();
  const revision = revisionOf(name);
  if (revision === 0 || !who) return putLocal({ programs: without(local.peek().programs, name) });
  try {
    await rpc.call('programs.remove', { robot: who, name, revision });
  } catch (error) {
    trouble.value = sentence(notKept(error), name);
    void refresh();
    return;
  }
  batch(() => {
    trouble.value = '';
    const now = controller.peek();
    if (now) controller.value = { ...now, programs: without(now.programs, name) };
    putLocal({ programs: without(local.peek().programs, name) });
  });
}

/** Mine in the place of theirs, which somebody has looked at and does not want. */
export async function keepMine(): Promise<boolean> {
  const now = clash.peek();
  return now !== null && (await keepProgram(now.name, now.text, now.revision));
}
export async function takeTheirs(): Promise<KeptText | null> {
  const now = clash.peek();
  if (!now) return null;
  await refresh();
  clash.value = null;
  const theirs = controller.peek()?.programs[now.name];
  putLocal({ programs: without(local.peek().programs, now.name) });
  return theirs ? { name: now.name, ...theirs } : null;
}
export interface KeptText {
  name: string;
  text: string;
  revision: number;
}

// --- Points.
/** One after the other: each says what it was made from. */
let last: Promise<unknown> = Promise.resolve();
export function changeKept(change: PointChange): Promise<boolean> {
  const next = last.then(() => changeNow(change));
  last = next.catch(() => undefined);
  return next;
}
async function changeNow(change: PointChange): Promise<boolean> {
  const who = robot.peek();
  const one = model.peek();
  if (!who || !one) return false;
  const now = controller.peek() ?? { points: [], pointsRevision: 0 };
  const done = await changePoints(rpc, who, one, measuresOf(one), change, now);
  if (kind.peek() !== one.robot) return !('why' in done);
  if ('why' in done) {
    const name = change.kind === 'save' ? (change.points[0]?.name ?? '') : change.name;
    trouble.value = sentence(done, name);
    if (done.why === 'conflict') void refresh();
    return false;
  }
  batch(() => {
    trouble.value = '';
    const kept = controller.peek();
    if (kept) controller.value = { ...kept, ...done };
    const names = change.kind === 'save' ? change.points.map((point) => point.name) : [];
    if (names.length > 0) putLocal({ points: local.peek().points.filter((point) => !names.includes(point.name)) });
  });
  return true;
}

export function keepPoints(points: readonly Point[]): Promise<boolean> {
  const names = new Set(points.map((one) => one.name));
  putLocal({ points: [...local.peek().points.filter((one) => !names.has(one.name)), ...points] });
  return whileSending([...names], () => changeKept({ kind: 'save', points }));
}
const isKept = (name: string): boolean => !!controller.peek()?.points.some((one) => one.name === name);
export async function dropPoint(name: string): Promise<void> {
  if (isKept(name) && !(await changeKept({ kind: 'remove', name }))) return;
  putLocal({ points: local.peek().points.filter((one) => one.name !== name) });
}
export async function renameKept(name: string, to: string): Promise<void> {
  if (isKept(name) && !(await changeKept({ kind: 'rename', name, to }))) return;
  putLocal({ points: local.peek().points.map((one) => (one.name === name ? { ...one, name: to } : one)) });
}

// --- What is in this browser only, to the controller.
/** Nothing is overwritten there: what has a name that is taken gets another one. */
export async function handOver(): Promise<void> {
  const { programs, points } = here.peek();
  for (const [name, text] of Object.entries(programs)) {
    const free = freeName(name, Object.keys(controller.peek()?.programs ?? {}));
    if (!(await keepProgram(free, text, 0))) return;
    if (free !== name) putLocal({ programs: without(local.peek().programs, name) });
  }
  if (points.length > 0) await keepPoints(points);
}
