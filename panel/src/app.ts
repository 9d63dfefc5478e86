/** The parts of the page tied together: one connection, one cell, one jog, what is chosen. */
import { batch, computed, effect, signal, untracked } from '@preact/signals';
import { errorSentence, kLanguages, language, preferredLanguage, refusalSentence, t, tWord, type Language } from './i18n';
import { Aims } from './logic/aims';
import { Jog, watchPage, type JogWish } from './logic/jog';
import { Latest } from './logic/latest';
import { parseRoute, routeText, tokenOf, type Route } from './logic/router';
import { ConnectionError, RpcClient, RpcError, wasOvertaken, type Socket } from './logic/rpc';
import { installStopKeys } from './logic/stop_keys';
import { isAtRest, isPlaceKnown, jointLimits, jointsOf, positionOf, Store, type PreviewTarget } from './logic/store';
import { ghostOf, question, sampleAt, type Target, type Verdict, type Way } from './logic/target';
import { toolPose } from './logic/kinematics';
import { fromFlat } from './logic/pose';
import type { PreviewJson, RefusalData, RobotModel } from './logic/types';
import { decimalMark, toRad } from './logic/units';
import type { Theme } from './scene/look';
import { kViewIds } from './view_ids';

const kKept = 'sinew.';
const keep = (key: string, value: string) => localStorage.setItem(kKept + key, value);
const kept = (key: string) => localStorage.getItem(kKept + key);

// --- The token of the start link.
const token = tokenOf(location.hash);
if (token) {
  sessionStorage.setItem(kKept + 'token', token);
  history.replaceState(null, '', location.pathname);
}

function connect(): Socket {
  const scheme = location.protocol === 'https:' ? 'wss' : 'ws';
  return new WebSocket(`${scheme}://${location.host}/ws`, ['sinew.v1']) as unknown as Socket;
}

export const rpc = new RpcClient({
  connect,
  onOpen: () => void store.opened(sessionStorage.getItem(kKept + 'token') ?? '').catch(() => undefined),
  onClose: () => {
    jog.stop('lost');
    store.closed();
  },
  onMessage: (method, params) => store.take(method, params),
});
export const store = new Store(rpc);
setInterval(() => store.lookAtAge(), 500);

// --- Looks.
export const theme = signal<Theme>('dark');
const darkWish = matchMedia('(prefers-color-scheme: dark)');
const keptTheme = kept('theme');
theme.value = keptTheme === 'dark' || keptTheme === 'light' ? keptTheme : darkWish.matches ? 'dark' : 'light';
darkWish.addEventListener('change', () => {
  if (!kept('theme')) theme.value = darkWish.matches ? 'dark' : 'light';
});
export function setTheme(wish: Theme): void {
  theme.value = wish;
  keep('theme', wish);
}
effect(() => {
  document.documentElement.dataset['theme'] = theme.value;
});

language.value = preferredLanguage(kept('language'), navigator.languages);
export function setLanguage(wish: Language): void {
  language.value = wish;
  keep('language', wish);
}
export const languages = Object.entries(kLanguages) as [Language, { name: string }][];
effect(() => {
  document.documentElement.lang = language.value;
  decimalMark.value = language.value === 'de' ? ',' : '.';
});

export const stopKeys = signal(kept('stop_keys') !== 'off');
export function setStopKeys(on: boolean): void {
  stopKeys.value = on;
  keep('stop_keys', on ? 'on' : 'off');
}

// --- Where we are.
const viewNames: readonly string[] = kViewIds;
export const route = signal<Route>(parseRoute(location.hash, viewNames));
addEventListener('hashchange', () => {
  route.value = parseRoute(location.hash, viewNames);
});
export function go(to: Partial<Route>): void {
  const next = { ...route.value, ...to };
  if (routeText(next) !== location.hash) location.hash = routeText(next);
}

/** The robot that everything on the right side is about; the first one where none is named. */
export const robot = computed<string | null>(() => {
  const names = store.robots.value.map((one) => one.name);
  const wish = route.value.robot;
  return wish && names.includes(wish) ? wish : (names[0] ?? null);
});
export const status = computed(() => (robot.value ? store.status.value[robot.value] : undefined));
const jaws = computed(() => status.value?.jaws_m);
/** With its jaws as they are now. */
export const model = computed<RobotModel | null>(() => {
  const one = robot.value ? store.models.value[robot.value] : undefined;
  if (one?.kind !== 'serial' || !one.geometry.gripper || jaws.value === undefined) return one ?? null;
  return { ...one, geometry: { ...one.geometry, gripper: { ...one.geometry.gripper, width_m: jaws.value } } };
});
export const atWork = computed(() => {
  const now = status.value;
  return now?.job ? !now.job.over : false;
});
/** Somebody knows where it stands, and it stands. */
export const knowsPlace = computed(() => {
  const now = status.value;
  return now !== undefined && isPlaceKnown(now) && isAtRest(now) && jointsOf(now, positionOf) !== null;
});
/** It would take motions from here, now; control is taken with the first one. */
export const canMove = computed(() => {
  const now = status.value;
  if (!now || !robot.value || store.connection.value !== 'open' || store.role.value !== 'operator') return false;
  return store.lease(robot.value) !== 'other' && !now.free_drive && (now.state === 'ready' || now.state === 'moving');
});

// --- Stop.
/** Said at once; the same words again are said again. */
export const announced = signal({ text: '', count: 0 });
/** Said when there is time for it. */
export const murmured = signal('');
/** The last Stop has not reached the controller. */
export const unheard = signal(false);
export function stop(): void {
  jog.stop('stopped');
  void store.stopAll().then((told) => {
    const text = told ? 'stop.done' : 'stop.failed';
    unheard.value = !told;
    announce([t(text)], []);
  });
}
effect(() => {
  if (store.connection.value === 'open') unheard.value = false;
});
// Space is Stop: what it would tick elsewhere, Enter does here.
window.addEventListener('keydown', (event) => {
  const box = event.target;
  if (event.key !== 'Enter' || !(box instanceof HTMLInputElement) || box.type !== 'checkbox') return;
  event.preventDefault();
  if (!event.repeat) box.click();
});
installStopKeys(window, { enabled: () => stopKeys.value, stop });

// --- Jog.
export const jogging = signal(false);
export const jog = new Jog({
  send: (wish, expiry) =>
    rpc.call('robot.jog', {
      robot: wish.robot,
      frame: wish.frame,
      velocity: wish.velocity,
      expiry_s: expiry,
    }),
  onChange: (moving) => {
    jogging.value = moving;
  },
  onEnd: (why, error) => {
    if (why === 'released' || why === 'stopped') return;
    const text = t(`jog.end.${why}`, { text: error ? refusalSentence(error) : '' });
    store.note(why === 'refused' ? 'refused' : 'lost', text, robot.value ?? undefined);
  },
});
watchPage(jog, window, document);
// Before the buttons, which let go when they are switched off, and give no reason.
effect(() => {
  if (jogging.value && jog.robot !== null && store.lease(jog.robot) === 'other') jog.stop('taken');
});

/** The pace of all motions, while somebody drags it. */
const pacing = new Latest<{ robot: string; share: number }, void>({
  intervalMs: 100,
  ask: ({ robot: name, share }) => store.feed(name, share),
  onAnswer: () => undefined,
  onError: () => undefined,
});
export const setPace = (name: string, share: number): void => pacing.put({ robot: name, share });

/** Begins once this page has control, if it is still wanted then. */
export async function holdOnce(source: string, wish: JogWish, wanted: () => boolean): Promise<void> {
  const before = jog.stops;
  if (!(await store.control(wish.robot))) return;
  if (wanted() && before === jog.stops) jog.hold(source, wish);
}

// --- Where it has come to rest: whatever was previewed begins there.
export const rested = signal<{ robot: string; joints: number[] } | null>(null);
/** A limp servo's reading trembles by less: rad, m. */
const kTrembles = { angle: toRad(0.5), length: 2e-4 };
effect(() => {
  const name = robot.value;
  const one = model.value;
  const now = status.value;
  const joints = jointsOf(now, positionOf);
  if (!name || !one || !now || !joints || !isAtRest(now)) return;
  const before = rested.peek();
  const still =
    before?.robot === name &&
    joints.every((q, i) => Math.abs(q - before.joints[i]!) < kTrembles[jointLimits(one.joints[i]!).measure]);
  if (!still) rested.value = { robot: name, joints };
});

// --- Preview.
const kWay: Way = { line: false, speed: 0.5 };
export const way = signal<Way>(kWay);
export const target = signal<Target | null>(null);
export const verdict = signal<Verdict>({ kind: 'checking' });
export const gizmoMode = signal<'translate' | 'rotate'>('translate');
/** Time in the preview that the ghost shows; nothing: its end. */
export const scrub = signal<number | null>(null);

/** Nobody looks at the target, so nothing was asked of it yet. */
const unasked = signal(false);
const asking = new Latest<{ robot: string; ask: PreviewTarget }, PreviewJson>({
  intervalMs: 100,
  ask: ({ robot: name, ask }) => store.preview(name, ask),
  onAnswer: (_, preview) => {
    const now = target.value;
    batch(() => {
      verdict.value = { kind: 'fine', preview };
      scrub.value = null;
      // What was not dragged follows what was.
      if (now && preview.to.positions && preview.to.tool) {
        const end = ghostOf(now, verdict.value);
        target.value =
          now.by === 'tool' ? { ...now, joints: end.joints } : { ...now, tool: end.platform };
      }
    });
  },
  onError: (_, error) => {
    // By one of another view: this one is asked again where somebody looks at it.
    if (wasOvertaken(error)) unasked.value = true;
    else if (error instanceof RpcError) {
      verdict.value = { kind: 'refused', sentence: error.message, data: (error.data ?? null) as RefusalData | null };
    } else if (error instanceof ConnectionError) {
      verdict.value = { kind: 'lost' };
    }
  },
});

/** Where it stands now, as a target to start from; at home where nobody knows. */
export function standing(): Target | null {
  const name = robot.value;
  const one = model.value;
  if (!name || !one) return null;
  const joints = jointsOf(status.value, positionOf) ?? one.joints.map((joint) => jointLimits(joint).home);
  const tool = one.kind === 'hexapod' ? status.value?.tool : undefined;
  return {
    robot: name,
    by: 'joints',
    joints,
    tool: tool ? fromFlat(tool) : toolPose(one, joints),
    turned: false,
  };
}

export function aim(next: Target): void {
  const one = model.value;
  if (!one) return;
  batch(() => {
    target.value = next;
    verdict.value = { kind: 'checking' };
    scrub.value = null;
    unasked.value = false;
  });
  asking.put({ robot: next.robot, ask: question(next, way.value, one) });
}
export function setWay(next: Way): void {
  way.value = next;
  if (target.value) aim(target.value);
}
export function forgetTarget(): void {
  asking.forget();
  batch(() => {
    target.value = null;
    scrub.value = null;
  });
}
export async function move(): Promise<void> {
  const now = verdict.value;
  if (!target.value || now.kind !== 'fine') return;
  const started = await store.run(target.value.robot, now.preview.text, t('view.move'));
  if (started) forgetTarget();
}
effect(() => {
  void robot.value;
  jog.stop('released');
});

// What was prepared for a robot stays there, behind another robot, a reload and a restart.
const aims = new Aims(localStorage);
addEventListener('pagehide', () => aims.flush());
let aimedFor: string | null = null;
effect(() => {
  const name = robot.value;
  const one = model.value;
  if (name && one) untracked(() => prepare(name, one));
});
function prepare(name: string, one: RobotModel): void {
  const now = target.peek();
  if (name === aimedFor) {
    // The controller is there again: what it said before was another start.
    if (now) aimLater(now);
    return;
  }
  aimedFor = name;
  const before = aims.load(name, one);
  batch(() => {
    forgetTarget();
    way.value = before?.way ?? kWay;
    if (before?.target) aimLater(before.target);
  });
}
function aimLater(next: Target): void {
  batch(() => {
    target.value = next;
    verdict.value = { kind: 'checking' };
    scrub.value = null;
    unasked.value = true;
  });
}
// It would begin elsewhere now.
effect(() => {
  void rested.value;
  untracked(() => target.value && aimLater(target.value));
});
effect(() => {
  if (unasked.value && target.value && route.value.view === 'move') untracked(() => aim(target.peek()!));
});
effect(() => {
  const now = { target: target.value, way: way.value };
  const one = model.peek();
  if (aimedFor && one && aimedFor === robot.peek()) aims.put(aimedFor, one, now);
});

/** What the ghost shows now. */
export const ghost = computed(() => {
  const now = target.value;
  if (!now) return null;
  const judged = verdict.value;
  const path = judged.kind === 'fine' ? judged.preview.samples.tool : undefined;
  const at = scrub.value !== null && judged.kind === 'fine' ? sampleAt(judged.preview, scrub.value) : null;
  return { robot: now.robot, path, ...ghostOf(now, judged), ...(at ?? {}) };
});

// --- What a screen reader hears: of several changes at once all, faults first.
const heard = new Map<string, string>();
const heardJobs = new Map<string, number>();
effect(() => {
  // A controller that was started anew counts its programs anew.
  if (store.connection.value !== 'open') return heardJobs.clear();
  const grave: string[] = [];
  const quiet: string[] = [];
  for (const one of Object.values(store.status.value)) {
    const known = heard.get(one.robot);
    heard.set(one.robot, one.state);
    if (known !== undefined && known !== one.state) {
      if (one.fault) grave.push(t('live.fault', { robot: one.robot, text: errorSentence(one.fault.error) }));
      else quiet.push(t('live.state', { robot: one.robot, state: tWord('state', one.state) }));
    }
    // The last one that has ended; 0 while one goes on.
    const over = one.job?.over ? one.job.job : 0;
    const before = heardJobs.get(one.robot);
    heardJobs.set(one.robot, over);
    if (before === undefined || over === 0 || over === before) continue;
    const { phase, title, error } = one.job!;
    const what = tWord('events.job', phase, { title, time: '', text: error ? errorSentence(error) : '' });
    (phase === 'failed' ? grave : quiet).push(t('live.state', { robot: one.robot, state: what }));
  }
  untracked(() => announce(grave, quiet));
});
function announce(grave: readonly string[], quiet: readonly string[]): void {
  // What brings no news leaves the other voice alone.
  if (grave.length > 0) announced.value = { text: grave.join(' '), count: announced.value.count + 1 };
  if (quiet.length > 0) murmured.value = quiet.join(' ');
}

export function start(): void {
  rpc.start();
}

// For tests of the page: nothing that the page itself could not do.
Object.assign(globalThis, { __sinew: { store, rpc } });
