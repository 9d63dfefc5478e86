/** What the plots show: the last minutes as they come, or a record; what is chosen of it. */
import { batch, computed, effect, signal } from '@preact/signals';
import { t } from './i18n';
import { robot, route, store } from './app';
import { frameOf, History, type Frame } from './logic/history';
import { kSpans, shownOf, type PlotWindow } from './logic/plot_window';
import { lengthOf, readRecord, standAt, type RunRecord } from './logic/record';
import type { Pick, Quantity } from './logic/series';
import type { CellRobot, RobotModel, ToolRow } from './logic/types';
import type { Ghost } from './scene/scene';

export type PlotMode = 'live' | 'record';
export const mode = signal<PlotMode>('live');
export const quantities = signal<readonly Quantity[]>(['position', 'error']);

// --- Live: always written, so that what led to something can be looked at behind it.
export const history = new History();
/** Grows with each frame that has come. */
export const newest = signal(0);
let trip: number | undefined;
effect(() => {
  const all = Object.values(store.status.value);
  if (all.length === 0) return;
  const scales = Object.fromEntries(store.robots.peek().map((one) => [one.name, one.time_scale]));
  if (history.add(frameOf(all, performance.now() / 1e3, scales, trip))) newest.value = history.last;
});
export const watched = computed(() => route.value.view === 'plots');

const kTripMs = 500;
effect(() => {
  if (!watched.value || mode.value !== 'live' || !quantities.value.includes('latency')) {
    trip = undefined;
    return;
  }
  let under = false;
  const timer = setInterval(() => {
    if (under || !(store.connection.peek() === 'open')) return;
    under = true;
    store
      .roundTrip()
      .then((ms) => (trip = ms))
      .catch(() => (trip = undefined))
      .finally(() => (under = false));
  }, kTripMs);
  return () => clearInterval(timer);
});

// --- What is chosen. Nothing said: all joints of the robot that is open.
export const chosen = signal<ReadonlySet<string> | null>(null);
export const keyOf = (name: string, joint: string): string => `${name}/${joint}`;
export const isChosen = (name: string, joint: string): boolean =>
  chosen.value ? chosen.value.has(keyOf(name, joint)) : name === robot.value;

export interface Choosable {
  name: string;
  joints: Pick[];
}

/** A hue a joint, and a kind of line for each robot of which something is chosen. */
const hueOf = (row: number, joint: number): number => 6 * row + (joint % 6);

export const choosable = computed<Choosable[]>(() => {
  if (mode.value === 'record') {
    const one = record.value;
    if (!one) return [];
    const joints = one.joints.map(({ name, measure }, joint): Pick => {
      return { robot: one.robot, joint, name, measure, hue: hueOf(0, joint) };
    });
    return [{ name: one.robot, joints }];
  }
  let rows = 0;
  return store.robots.value.map(({ name }) => {
    const all = store.models.value[name]?.joints ?? [];
    const row = all.some((each) => isChosen(name, each.name)) ? rows++ : 0;
    const joints = all.map((each, joint): Pick => {
      const measure = each.kind === 'prismatic' ? 'length' : 'angle';
      return { robot: name, joint, name: each.name, measure, hue: hueOf(row, joint) };
    });
    return { name, joints };
  });
});
export const picks = computed<Pick[]>(() => {
  const all = choosable.value.flatMap((one) => one.joints);
  const wanted = all.filter((one) => isChosen(one.robot, one.name));
  // A record of somebody who is not here has to show something, too.
  return mode.value === 'record' && chosen.value === null ? all : wanted;
});
export function choose(name: string, joints: readonly string[], on: boolean): void {
  const next = new Set(picks.peek().map((one) => keyOf(one.robot, one.name)));
  for (const joint of joints) {
    if (on) next.add(keyOf(name, joint));
    else next.delete(keyOf(name, joint));
  }
  chosen.value = next;
}
export function setQuantity(which: Quantity, on: boolean): void {
  const rest = quantities.value.filter((one) => one !== which);
  quantities.value = on ? [...rest, which] : rest;
}

// --- The window.
export const liveWindow = signal<PlotWindow>({ span: kSpans[0], held: null });
export const recordWindow = signal<PlotWindow>({ span: 10, held: null });
/** What "now" was when the picture was held. */
let heldNewest = 0;
let wasHeld = false;
effect(() => {
  const held = liveWindow.value.held !== null;
  if (held && !wasHeld) heldNewest = newest.peek();
  wasHeld = held;
});
/** The zero of the time that is shown. */
export const zeroTime = (): number =>
  mode.value === 'record' ? 0 : liveWindow.value.held ? heldNewest : newest.peek();
export const frames = (): readonly Frame[] =>
  mode.value === 'live' ? history.frames : (record.value?.frames ?? []);
export const ends = (): { oldest: number; newest: number } => {
  const all = frames();
  return { oldest: all[0]?.t ?? 0, newest: all.at(-1)?.t ?? 0 };
};
export const windowNow = () => (mode.value === 'live' ? liveWindow : recordWindow);
export const shownNow = () => shownOf(windowNow().value, mode.value === 'live' ? newest.value : ends().newest);

// --- A record.
export const record = signal<RunRecord | null>(null);
export const recordName = signal('');
export const recordTrouble = signal('');
/** s of the record that the 3D view shows. */
export const playhead = signal(0);
export const playing = signal(false);
export const playSpeed = signal(1);
/** The robot of the cell that stands for it. */
export const standsFor = signal<string | null>(null);

const kBytesMax = 512 * 1024 * 1024;

export async function loadRecord(file: File): Promise<void> {
  recordTrouble.value = '';
  try {
    if (file.size > kBytesMax) throw new Error(t('plots.record.big'));
    const one = readRecord(new Uint8Array(await file.arrayBuffer()));
    if (one.frames.length === 0) throw new Error(t('plots.record.empty'));
    batch(() => {
      record.value = one;
      recordName.value = file.name;
      mode.value = 'record';
      chosen.value = null;
      playing.value = false;
      playhead.value = one.frames[0]!.t;
      recordWindow.value = { span: 10, held: { low: one.frames[0]!.t, high: lengthOf(one) } };
      standsFor.value = candidates(one, store.robots.value, store.models.value)[0] ?? null;
    });
  } catch (error) {
    const what = (error as { what?: string }).what;
    recordTrouble.value = what ? t(`plots.record.${what}` as 'plots.record.magic') : (error as Error).message;
  }
}

/** Robots of this cell that look as the one of the record: its own name first. */
export function candidates(one: RunRecord, robots: readonly CellRobot[], models: Record<string, RobotModel>): string[] {
  const same = robots.filter((each) => {
    const joints = models[each.name]?.joints.map((joint) => joint.name) ?? [];
    return joints.length === one.joints.length && joints.every((name, i) => name === one.joints[i]!.name);
  });
  return same.map((each) => each.name).sort((a, b) => Number(b === one.robot) - Number(a === one.robot));
}

const kPathPoints = 1500;
const toolPath = computed<ToolRow[]>(() => {
  const all = record.value?.tool ?? [];
  const every = Math.max(1, Math.ceil(all.length / kPathPoints));
  return all.filter((_, i) => i % every === 0).map(({ pose }): ToolRow => [...pose.p, ...pose.q]);
});

/** What the 3D view shows of the record. */
export const replayGhost = computed<Ghost | null>(() => {
  const one = record.value;
  const name = standsFor.value;
  if (!watched.value || mode.value !== 'record' || !one || !name) return null;
  const stand = standAt(one, playhead.value);
  return stand && { robot: name, joints: stand.joints, platform: stand.platform, refused: false, path: toolPath.value };
});
