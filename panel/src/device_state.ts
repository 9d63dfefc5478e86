/** What the device view shows: the device's last answers and what passes on its wire. */
import { batch, effect, signal } from '@preact/signals';
import { robot, route, store } from './app';
import type { DeviceJson } from './logic/device';
import { language, tWord } from './i18n';
import { appended, matches, type WireAnswer, type WireFilter, type WireFrame } from './logic/wire';

const kStatusMs = 500;
const kWireMs = 250;
const kLimit = 1000;

export const device = signal<DeviceJson | null>(null);
export const frames = signal<WireFrame[]>([]);
/** Messages since the list was cleared that did not make it here. */
export const lost = signal(0);
export const paused = signal(false);
export const filter = signal<WireFilter>({ way: 'both', words: '', fill: false });
/** Sequence of the message that is looked at closely. */
export const chosen = signal<number | null>(null);

/**
 * Those that the filter lets through. They are kept apart: of a wire with thousands of messages a
 * second the rare ones that somebody waits for stay.
 */
export const matched = signal<WireFrame[]>([]);
const fitting = (all: readonly WireFrame[]): WireFrame[] => all.filter((one) => matches(one, filter.peek(), sentence(one)));
effect(() => {
  void [filter.value, language.value];
  matched.value = fitting(frames.peek());
});

/** The message and its values in the language at hand. */
export function sentence(frame: WireFrame): string {
  const values = frame.fields.map(([name, value]) => {
    const shown = typeof value === 'string' ? tWord('wire.value', value) : Number(value.toPrecision(7));
    return `${tWord('wire.field', name)} ${shown}`;
  });
  const name = tWord('wire.m', frame.name);
  return values.length > 0 ? `${name}: ${values.join(', ')}` : name;
}

let since = 0;

export function clear(): void {
  batch(() => {
    frames.value = [];
    matched.value = [];
    lost.value = 0;
    chosen.value = null;
  });
}

/** Asks again and again while `robot` is looked at; one question at a time. */
function every(ms: number, ask: (name: string) => Promise<void>): () => void {
  let under = false;
  const turn = () => {
    const name = robot.peek();
    if (under || !name || store.connection.peek() !== 'open') return;
    under = true;
    ask(name)
      .catch(() => undefined) // the page says itself that the connection is gone
      .finally(() => (under = false));
  };
  turn();
  const timer = setInterval(turn, ms);
  return () => clearInterval(timer);
}

// Another robot is another wire.
effect(() => {
  void robot.value;
  since = 0;
  batch(() => {
    device.value = null;
    clear();
  });
});
const open = () => route.value.view === 'device' && robot.value !== null && store.connection.value === 'open';
effect(() => {
  if (!open()) return;
  return every(kStatusMs, async (name) => {
    const told = await store.call<DeviceJson>('device.status', { robot: name });
    if (robot.peek() === name) device.value = told;
  });
});
effect(() => {
  if (!open() || paused.value) return;
  return every(kWireMs, async (name) => {
    const told = await store.call<WireAnswer>('wire.read', { robot: name, since, limit: kLimit });
    if (robot.peek() !== name || paused.peek()) return;
    batch(() => {
      // A controller that was started anew counts anew.
      if (told.last < since) clear();
      since = told.last;
      lost.value += told.lost;
      if (told.frames.length === 0) return;
      frames.value = appended(frames.value, told.frames);
      const more = fitting(told.frames);
      if (more.length > 0) matched.value = appended(matched.value, more);
    });
  });
});
