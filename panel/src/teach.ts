/** Programs and points of the robot that is chosen: what is open, what the server says to it, what runs. */
import { batch, computed, effect, signal, untracked } from '@preact/signals';
import { atWork, model, rested, robot, route, rpc, status, store, way } from './app';
import { calledBy, expand, withPoints, type Expanded } from './logic/expand';
import { Latest } from './logic/latest';
import { freeName, readPoints, takePoint, writePoints, type NotTaught, type Point } from './logic/points';
import { ConnectionError, RpcError, wasOvertaken } from './logic/rpc';
import { jointRow } from './logic/quantities';
import { fromRow } from './logic/pose';
import { readRows } from './logic/rows';
import { fileKind, type Draft } from './logic/shelf';
import { sampleAt } from './logic/target';
import { judged, refusal, type ProgramVerdict, type RowVerdict } from './logic/verdicts';
import { language, refusalSentence, t, type Key } from './i18n';
import {
  clash,
  dropPoint,
  dropProgram,
  here,
  keepMine,
  keepPoints,
  keepProgram,
  keeps,
  kind,
  measuresOf,
  putDraft,
  renameKept,
  revisionOf,
  shelf,
  takeTheirs,
} from './shelf_state';
import type { CheckJson, PreviewJson, RefusalData, RobotModel } from './logic/types';
import type { Ghost } from './scene/scene';

const kHistoryMax = 100;
const kPreviewSamples = 400;
/** Planning a long program takes its time. */
const kCheckMs = 120_000;

export type TeachTab = 'points' | 'program' | 'ride';
export const tab = signal<TeachTab>('program');
export { here, keeps, measuresOf, shelf };
/** Line of the row that is open. */
export const selected = signal<number | null>(null);
export const verdict = signal<ProgramVerdict>({ kind: 'none' });
/** Time in the preview that the ghost shows; nothing: none. */
export const scrub = signal<number | null>(null);
/** What was just done, for who cannot see it. */
export const said = signal('');
export const history = signal<Draft[]>([]);

export const text = computed(() => shelf.value.draft.text);
export const name = computed(() => shelf.value.draft.name);
export const changed = computed(() => {
  const saved = shelf.value.programs[name.value];
  return saved === undefined ? text.value.trim() !== '' : saved !== text.value;
});

// --- Examples that come with Sinew.
const files = import.meta.glob<string>('../../robots/*/**/*.{sinew,txt,pos,gcode}', { query: '?raw', import: 'default', eager: true });
const pointFiles = import.meta.glob<string>('../../robots/*/**/points.toml', { query: '?raw', import: 'default', eager: true });
const kExample = /\/robots\/([^/]+)\/(?:.*\/)?([^/]+)\.(sinew|txt|pos|gcode)$/;
export const examples = computed(() =>
  Object.keys(files).flatMap((path) => {
    const match = kExample.exec(path);
    return match && match[1] === kind.value ? [{ path, name: match[2]! }] : [];
  }),
);
/** With what stands beside it: the programs that it calls, and points, but for those that are here already. */
export function openExample(path: string): void {
  const found = files[path];
  if (found === undefined) return;
  const form = fileKind(path);
  if (form !== 'program') return void importExample(kExample.exec(path)![2]!, found, form);
  const folder = path.slice(0, path.lastIndexOf('/') + 1);
  const beside = Object.fromEntries(
    Object.entries(files)
      .filter(([other]) => other.startsWith(folder) && other.endsWith('.sinew'))
      .map(([other, content]) => [kExample.exec(other)![2]!, content]),
  );
  const { points, programs } = shelf.peek();
  const near = readPoints(pointFiles[`${folder}points.toml`] ?? '').points.map((one) => one.point);
  batch(() => {
    openProgram(kExample.exec(path)![2]!, found);
    const more = near.filter((one) => !points.some((other) => other.name === one.name));
    if (more.length > 0) void keepPoints(more);
    for (const [other, content] of Object.entries(calledBy(found, beside))) {
      if (!(other in programs)) void keepProgram(other, content, 0);
    }
  });
}

/** Of another form: the controller makes steps of it. */
async function importExample(title: string, content: string, form: string): Promise<void> {
  try {
    openProgram(title, (await rpc.call<{ text: string }>('program.import', { robot: robot.peek(), text: content, form })).text);
    say('prog.opened', { name: title });
  } catch (error) {
    said.value = refusalSentence(error as Error);
  }
}

// --- Changing the text.
export function edit(next: string, line?: number | null): void {
  const before = shelf.peek().draft;
  if (next === before.text) return;
  batch(() => {
    // Letters that are typed one after the other are one change.
    const typed = line === undefined && history.peek().length > 0 && Date.now() - lastTyped < 1000;
    lastTyped = line === undefined ? Date.now() : 0;
    if (!typed) history.value = [...history.peek(), before].slice(-kHistoryMax);
    putDraft({ ...before, text: next });
    if (line !== undefined) selected.value = line;
  });
}
let lastTyped = 0;
export function undo(): void {
  const before = history.peek().at(-1);
  if (before === undefined) return;
  batch(() => {
    history.value = history.peek().slice(0, -1);
    selected.value = null;
    putDraft(before);
  });
}
/** @param revision  of the kept text; nothing: it is not kept */
export function openProgram(title: string, next: string, revision?: number): void {
  batch(() => {
    history.value = [...history.peek(), shelf.peek().draft].slice(-kHistoryMax);
    selected.value = null;
    putDraft({ name: title, text: next, ...(revision ? { revision } : {}) });
  });
}
export function openKept(title: string): void {
  openProgram(title, shelf.peek().programs[title] ?? '', revisionOf(title));
}
/** Under the name that it was opened by it replaces that text, under another one nothing. */
export async function saveAs(title: string): Promise<void> {
  const { name: opened, revision } = shelf.peek().draft;
  const made = opened === title ? (revision ?? 0) : 0;
  putDraft({ name: title, text: text.peek(), ...(made ? { revision: made } : {}) });
  if (await keepProgram(title, text.peek(), made)) say('prog.saved', { name: title });
}
export async function openTheirs(): Promise<void> {
  const theirs = await takeTheirs();
  if (theirs) openProgram(theirs.name, theirs.text, theirs.revision);
}
export async function saveMine(): Promise<void> {
  const title = clash.peek()?.name ?? '';
  if (await keepMine()) say('prog.saved', { name: title });
}
export function say(key: Key, values: Record<string, string | number> = {}): void {
  said.value = t(key, values);
}

// --- What the server says to it.
interface Asked {
  robot: string;
  program: { text: string; points: string; called: Record<string, string> };
  programs: Readonly<Record<string, string>>;
  expanded: Expanded;
}
const asking = new Latest<Asked, CheckJson>({
  intervalMs: 500,
  ask: ({ robot: one, program }) => store.check(one, program, kCheckMs),
  onAnswer: (asked, told) => {
    verdict.value = judged(asked.program.text, told, asked.programs, asked.expanded);
    // What can be seen of it is another question: a run does not wait for it.
    if (told.fine && asked.expanded.open.length === 0) previewing.put(asked);
  },
  onError: ({ expanded }, error) => {
    if (error instanceof RpcError) verdict.value = refusal(error.message, error.data, expanded);
    else if (error instanceof ConnectionError) verdict.value = { kind: 'lost' };
  },
});
const previewing = new Latest<Asked, PreviewJson>({
  intervalMs: 0,
  ask: ({ robot: one, expanded }) =>
    store.preview(one, { text: expanded.text, samples: kPreviewSamples }, kCheckMs),
  onAnswer: (_, preview) => {
    const now = verdict.peek();
    if (now.kind === 'fine') verdict.value = { ...now, preview };
  },
  onError: (_, error) => {
    const now = verdict.peek();
    if (!(error instanceof RpcError) || now.kind !== 'fine' || wasOvertaken(error)) return;
    verdict.value = { ...now, unseen: { sentence: error.message, data: (error.data ?? null) as RefusalData | null } };
  },
});
export function check(): void {
  const one = model.peek();
  const who = robot.peek();
  if (!one || !who) return;
  const { points, programs, draft } = shelf.peek();
  scrub.value = null;
  previewing.forget();
  if (draft.text.trim() === '') {
    asking.forget();
    verdict.value = { kind: 'none' };
    return;
  }
  verdict.value = { kind: 'checking' };
  asking.put({ robot: who, programs, expanded: expand(draft.text, one, points, programs), program: wholeProgram(one) });
}
/** The text with all that it needs, as it is checked and as it runs. */
function wholeProgram(one: RobotModel): Asked['program'] {
  const { points, programs, draft } = shelf.peek();
  return {
    text: draft.text,
    points: writePoints(one.robot, points, measuresOf(one)),
    called: calledBy(draft.text, programs),
  };
}
const shown = computed(() => route.value.view === 'programs' && store.connection.value === 'open');
// Whatever a check depends on: the text, the points, which robot, and where it has come to rest.
const known = computed(() => status.value?.position ?? null);
effect(() => {
  void [text.value, shelf.value.points, shelf.value.programs, robot.value, kind.value, known.value, rested.value];
  if (shown.value && tab.value === 'program' && !atWork.value) untracked(check);
});
export const verdicts = computed((): Record<number, RowVerdict> => {
  const now = verdict.value;
  const told = now.kind === 'fine' || now.kind === 'refused' ? now.judged : null;
  return told && told.text === text.value ? told.rows : {};
});

// --- What runs.
/** What this page has started last: its rows are marked only in the text that it was. */
const ran = signal<{ robot: string; job: number; text: string } | null>(null);
const ours = computed(() => {
  const now = status.value?.job;
  return now !== undefined && ran.value?.robot === robot.value && ran.value?.job === now.job ? ran.value : null;
});
/** By its name where another client has started it. */
const isThis = computed(() => ours.value !== null || status.value?.job?.title === programTitle());
/** Of another name only while it waits for a client. */
export const job = computed(() => {
  const now = status.value?.job;
  return now && (isThis.value || (now.client_lost && !now.over)) ? now : null;
});
/** The text was changed since it began. */
export const outdated = computed(() => ours.value !== null && ours.value.text !== text.value);
export const programTitle = (): string => name.value || 'program';
export const running = computed(() => (job.value && !job.value.over ? job.value : null));
export const runningLine = computed(() =>
  running.value && running.value.line > 0 && isThis.value && !outdated.value ? running.value.line : null,
);
export const failedLine = computed(() =>
  job.value?.over && job.value.phase === 'failed' && !outdated.value ? (job.value.error?.line ?? null) : null,
);
/** Where it was stopped, and could go on. */
export const brokenOffLine = computed(() => {
  const now = job.value;
  if (!now?.over || now.phase === 'done' || outdated.value || !ours.value) return null;
  const row = readRows(text.value).rows[now.line - 1];
  return row && row.depth === 0 && row.word !== 'end' ? now.line : null;
});

// A controller that was started anew counts its programs anew.
effect(() => {
  if (store.connection.value !== 'open') ran.value = null;
});

export async function run(options: { fromLine?: number; singleStep?: boolean } = {}): Promise<void> {
  const who = robot.peek();
  const one = model.peek();
  if (!who || !one || !(await store.control(who))) return;
  const { points, ...program } = wholeProgram(one);
  const begun = await store.ask<{ job: number }>('program.run', {
    robot: who,
    ...program,
    name: programTitle(),
    ...(points ? { points } : {}),
    ...(options.fromLine ? { from_line: options.fromLine } : {}),
    ...(options.singleStep ? { single_step: true } : {}),
  });
  if (begun) ran.value = { robot: who, job: begun.job, text: program.text };
}
const ask = (method: string, params: object = {}): void => {
  if (robot.peek()) void store.ask(method, { robot: robot.peek()!, ...params });
};
export const pause = (): void => ask('robot.hold');
export const resume = (): void => {
  if (robot.peek()) void store.resume(robot.peek()!);
};
export const stopJob = (): void => ask('robot.stop');
/** The next order, then a pause; where nothing runs yet, from the beginning. */
export function step(back = false): void {
  if (running.peek()) ask('program.step', back ? { back: true } : {});
  else if (!back) void run({ singleStep: true });
}
export async function ride(order: { seed: number; duration_s: number; amplitude?: number }): Promise<void> {
  const who = robot.peek();
  if (who && (await store.control(who))) ask('robot.bullride', order);
}

// --- Points.
export function take(wish: string): { wrong: NotTaught; joint?: string } | Point | null {
  const one = model.peek();
  if (!one) return null;
  const { points } = shelf.peek();
  const taken = takePoint(freeName(wish, points.map((point) => point.name)), one, status.peek(), new Date());
  if ('wrong' in taken) return taken;
  void keepPoints([taken]);
  say('pts.taken', { name: taken.name });
  return taken;
}
export function retake(old: string): { wrong: NotTaught; joint?: string } | Point | null {
  const one = model.peek();
  if (!one) return null;
  const taken = takePoint(old, one, status.peek(), new Date());
  if ('wrong' in taken) return taken;
  void keepPoints([taken]);
  say('pts.taken', { name: old });
  return taken;
}
export const renamePoint = (old: string, next: string): void => void renameKept(old, next);
export const removePoint = (old: string): void => void dropPoint(old);
export const addPoints = (more: readonly Point[]): void => void (more.length > 0 && keepPoints(more));
export const removeProgram = (title: string): void => void dropProgram(title);

// --- On the way to a point: seen first, moved then.
export interface Going {
  point: string;
  verdict: ProgramVerdict;
}
export const going = signal<Going | null>(null);
const heading = new Latest<{ robot: string; point: string; expanded: Expanded }, PreviewJson>({
  intervalMs: 100,
  ask: ({ robot: one, expanded }) => store.preview(one, { text: expanded.text }, kCheckMs),
  onAnswer: ({ point }, preview) => (going.value = { point, verdict: { kind: 'fine', judged: null, preview, hidden: [] } }),
  onError: ({ point, expanded }, error) => {
    // By another page or view of ours: this one is asked again when somebody looks at it.
    if (wasOvertaken(error)) stay();
    else if (error instanceof RpcError) going.value = { point, verdict: refusal(error.message, error.data, expanded) };
    else if (error instanceof ConnectionError) going.value = { point, verdict: { kind: 'lost' } };
  },
});
export function head(point: Point): void {
  const one = model.peek();
  const who = robot.peek();
  if (!one || !who) return;
  const pace = way.peek().speed < 1 && one.takes_speed ? ` speed=${Math.round(100 * way.peek().speed)}%` : '';
  const place = point.joints ? { body: jointRow(one, point.joints, 4) } : withPoints(`move to=${point.name}`, one, [point]);
  if (!('body' in place)) return;
  going.value = { point: point.name, verdict: { kind: 'checking' } };
  heading.put({ robot: who, point: point.name, expanded: { text: place.body + pace, lines: [1], missing: [], open: [] } });
}
export function stay(): void {
  heading.forget();
  going.value = null;
}
/** The very rows that were previewed. */
export async function goThere(): Promise<void> {
  const now = going.peek();
  const who = robot.peek();
  if (!who || now?.verdict.kind !== 'fine' || !now.verdict.preview) return;
  if (await store.run(who, now.verdict.preview.text, now.point)) stay();
}
effect(() => {
  void robot.value;
  stay();
});
// The way was seen from where it stood then.
effect(() => {
  void rested.value;
  // Asked where it is looked at: elsewhere other previews would overtake it.
  if (!shown.value || tab.value !== 'points' || atWork.value) return;
  untracked(() => {
    const point = shelf.value.points.find((one) => one.name === going.value?.point);
    if (point) head(point);
  });
});

// --- What the 3D view shows of it.
const preview = computed<PreviewJson | null>(() => {
  const now = tab.value === 'points' ? going.value?.verdict : tab.value === 'program' ? verdict.value : null;
  return now?.kind === 'fine' ? now.preview : null;
});
export const ghost = computed<Ghost | null>(() => {
  const now = preview.value;
  const who = robot.value;
  if (!now || !who || now.robot !== who || !now.to.positions || !now.to.tool) return null;
  const path = now.samples.tool;
  const at = scrub.value !== null && tab.value === 'program' ? sampleAt(now, scrub.value) : null;
  if (at) return { robot: who, path, refused: false, ...at };
  return { robot: who, path, refused: false, joints: now.to.positions, platform: fromRow(now.to.tool) };
});

// Sentences are made when they are said: another language begins with none.
effect(() => {
  void language.value;
  said.value = '';
});

// Another kind of robot has another shelf.
effect(() => {
  void kind.value;
  batch(() => {
    selected.value = null;
    history.value = [];
    going.value = null;
    verdict.value = { kind: 'none' };
  });
});
