/** The calibration of a camera, step by step. Its views are with the controller: a page that is loaded again goes on. */
import { batch, computed, effect, signal } from '@preact/signals';
import { store } from './app';
import { calibrating, camera, cameraName, open } from './camera_state';
import { handOver } from './hand_over';
import { errorSentence, refusalSentence, complaintSentence, t } from './i18n';
import { nextMark } from './logic/calibration';
import type { Calibration } from './logic/types';

export type Paper = 'a4' | 'a3' | 'letter';
export type WizardStep = 'print' | 'board' | 'sheet' | 'touch' | 'result';

export const calibration = signal<Calibration | null>(null);
export const wizardStep = signal<WizardStep>('print');
export const paper = signal<Paper>('a4');
export const busy = signal(false);
/** What became of the last click: a view or a mark that was taken, or why it was not. */
export const said = signal<{ kind: 'taken' | 'refused'; text: string } | null>(null);
export const sheetStays = signal(true);
/** Whether the wizard may be left is being asked. */
export const leaving = signal(false);
export const saved = signal<Calibration['saved'] | null>(null);

export const views = computed(() => calibration.value?.views ?? []);
/** The mark that the tip goes to next; the wizard's own choice where none was made. */
export const chosenMark = signal<string | null>(null);
/** m, that a pin stands out of the tool; 0: not said yet. */
export const pin = signal(0);
export const mark = computed(() => chosenMark.value ?? nextMark(calibration.value));
/** Something that is not saved yet. */
export const unsaved = computed(
  () => views.value.length + (calibration.value?.sheet ? 1 : 0) + (calibration.value?.touch?.marks.length ?? 0),
);

/** How it stands, whoever has changed it. */
effect(() => {
  const name = cameraName.value;
  batch(() => {
    calibration.value = null;
    calibrating.value = false;
    saved.value = null;
    said.value = null;
    chosenMark.value = null;
  });
  if (!open.value || !name) return;
  void store
    .call<Calibration>('camera.calibration.status', { camera: name })
    .then((now) => {
      if (camera.peek()?.name === name) calibration.value = now;
    })
    .catch(() => {
      // The page says itself that the connection is gone.
    });
});

function sentenceOf(error: unknown): string {
  const { message, data } = error as { message: string; data?: { code?: string } };
  // Of a camera that gives no picture the code says it; all else is known by its words.
  return data?.code?.startsWith('camera_') ? errorSentence({ ...data, sentence: message }) : complaintSentence(message) || refusalSentence({ message });
}

async function ask(method: string, params: object = {}): Promise<Calibration | null> {
  const name = camera.peek()?.name;
  if (!name || busy.peek()) return null;
  busy.value = true;
  said.value = null;
  try {
    const now = await store.call<Calibration>(`camera.calibration.${method}`, { camera: name, ...params });
    if (camera.peek()?.name === name) calibration.value = now;
    return now;
  } catch (error) {
    said.value = { kind: 'refused', text: sentenceOf(error) };
    const { data } = error as { data?: { code?: string } };
    if (data?.code === 'not_begun' || data?.code === 'begun_again') await look();
    return null;
  } finally {
    busy.value = false;
  }
}

/** Another client has changed it. */
async function look(): Promise<void> {
  const name = camera.peek()?.name;
  if (name) calibration.value = await store.call<Calibration>('camera.calibration.status', { camera: name });
}

const session = (): object => ({ session: calibration.peek()?.session ?? 0 });

export function openWizard(): void {
  const now = calibration.peek();
  batch(() => {
    calibrating.value = true;
    saved.value = null;
    said.value = null;
    leaving.value = false;
    if (now?.under_way) paper.value = (now.paper as Paper | undefined) ?? 'a4';
    wizardStep.value = !now?.under_way ? 'print' : now.result && now.step !== 'touch' ? 'result' : (now.step ?? 'board');
  });
}

export async function begin(): Promise<void> {
  const other = calibration.peek()?.under_way && calibration.peek()?.paper !== paper.peek();
  const now = await ask('begin', { paper: paper.peek(), ...(other ? { anew: true } : {}) });
  if (now) wizardStep.value = 'board';
}

export async function goTo(step: WizardStep): Promise<void> {
  if (step === 'board' || step === 'sheet' || step === 'touch') {
    if (!calibration.peek()?.under_way) return begin();
    if (!(await ask('expect', { ...session(), step }))) return;
  }
  batch(() => {
    said.value = null;
    wizardStep.value = step;
  });
}

export async function take(): Promise<void> {
  const before = wizardStep.peek();
  const now = await ask('take', session());
  if (!now?.taken) return;
  said.value = { kind: 'taken', text: t('cal.taken', { view: now.taken }) };
  if (before === 'sheet' && now.result) await goTo('touch');
}

/** The tip of this robot's tool is on the mark. */
export async function touch(robot: string): Promise<void> {
  const there = mark.peek();
  if (!there || !(await ask('touch', { ...session(), robot, mark: there, pin_m: pin.peek() }))) return;
  batch(() => {
    said.value = { kind: 'taken', text: t('cal.touch.taken', { mark: there }) };
    chosenMark.value = null;
  });
}

/** @param what  a view, or a mark that was touched */
export async function drop(what: { view: number } | { mark: string }): Promise<void> {
  await ask('drop', { ...session(), ...what });
}

export async function save(): Promise<void> {
  const now = await ask('save', { ...session(), sheet_stays: sheetStays.peek() });
  if (!now?.saved) return;
  saved.value = now.saved;
  await store.describeAgain();
}

/** @param discard  what is not saved; else it stays with the controller */
export async function leave(discard: boolean): Promise<void> {
  if (discard && calibration.peek()?.under_way && !(await ask('end', session()))) return;
  batch(() => {
    calibrating.value = false;
    leaving.value = false;
    said.value = null;
    saved.value = null;
  });
}

export function askToLeave(): void {
  if (calibration.peek()?.under_way && !saved.peek()) leaving.value = true;
  else void leave(false);
}

export async function print(what: 'board' | 'sheet', form: 'pdf' | 'svg'): Promise<void> {
  try {
    const { text } = await store.call<{ text: string }>('camera.print', { what, form, paper: paper.peek() });
    handOver(`sinew-${what}-${paper.peek()}.${form}`, text, form === 'pdf' ? 'application/pdf' : 'image/svg+xml');
  } catch (error) {
    said.value = { kind: 'refused', text: sentenceOf(error) };
  }
}
