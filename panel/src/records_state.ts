/** Records that the controller keeps: what is recorded now, and what can be had. */
import { batch, computed, effect, signal, untracked } from '@preact/signals';
import { robot, route, rpc, store } from './app';
import { fetchRecord, type KeptRecords, type RecordForm } from './logic/records';
import { notKept } from './logic/kept';
import { handOver } from './hand_over';
import { loadRecord } from './plots_state';

export const records = signal<KeptRecords | null>(null);
export const recordsTrouble = signal('');
/** What is being fetched, and how much of it is there. */
export const fetching = signal<{ record: string; form: RecordForm | 'play'; share: number } | null>(null);
/** Robots that the next recording is of; nothing: the one that is open. */
export const wanted = signal<ReadonlySet<string> | null>(null);
export const wantedNow = computed(() => wanted.value ?? new Set(robot.value ? [robot.value] : []));
export const recorded = computed(() => Object.values(store.status.value).filter((one) => one.recording));

function tell(error: unknown): void {
  const why = notKept(error);
  recordsTrouble.value = why.why === 'refused' ? why.sentence : '';
}

let asked = 0;
export async function refreshRecords(): Promise<void> {
  const turn = ++asked;
  try {
    const told = await rpc.call<KeptRecords>('records.list', {}, 30_000);
    if (turn === asked) records.value = told;
  } catch (error) {
    tell(error);
  }
}
const kept = computed(() => Object.values(store.status.value)[0]?.kept ?? 0);
const told = computed(() => store.events.value.filter((one) => one.kind === 'record').at(-1)?.number ?? 0);
const recording = computed(() => recorded.value.map((one) => one.robot).join(' '));
const shown = computed(() => route.value.view === 'plots' && store.connection.value === 'open');
effect(() => {
  void [kept.value, told.value, recording.value];
  if (shown.value) untracked(() => void refreshRecords());
});

export async function startRecording(title: string): Promise<void> {
  recordsTrouble.value = '';
  for (const one of wantedNow.peek()) {
    if (store.status.peek()[one]?.recording) continue;
    try {
      await rpc.call('record.start', { robot: one, ...(title ? { title } : {}) });
    } catch (error) {
      tell(error);
    }
  }
}
export async function stopRecording(): Promise<void> {
  for (const one of recorded.peek()) {
    try {
      const ended = await rpc.call<{ trouble?: string }>('record.stop', { robot: one.robot }, 30_000);
      if (ended.trouble) recordsTrouble.value = ended.trouble;
    } catch (error) {
      tell(error);
    }
  }
}
export async function removeRecord(record: string): Promise<void> {
  recordsTrouble.value = '';
  try {
    await rpc.call('records.remove', { record });
  } catch (error) {
    tell(error);
  }
  void refreshRecords();
}

async function fetched(record: string, form: RecordForm | 'play'): Promise<Uint8Array<ArrayBuffer>[] | null> {
  recordsTrouble.value = '';
  fetching.value = { record, form, share: 0 };
  const mine = () => fetching.peek()?.record === record && fetching.peek()?.form === form;
  try {
    const parts = await fetchRecord(
      rpc,
      record,
      form === 'csv' ? 'csv' : 'mcap',
      (share) => mine() && (fetching.value = { record, form, share }),
      mine,
    );
    if (mine()) fetching.value = null;
    return parts;
  } catch (error) {
    batch(() => {
      if (mine()) fetching.value = null;
      tell(error);
    });
    return null;
  }
}
/** To this computer. */
export async function download(record: string, form: RecordForm): Promise<void> {
  const parts = await fetched(record, form);
  if (parts) handOver(form === 'csv' ? record.replace(/\.mcap$/, '.csv') : record, parts, form === 'csv' ? 'text/csv;charset=utf-8' : 'application/octet-stream');
}
/** In the 3D view. */
export async function play(record: string): Promise<void> {
  const parts = await fetched(record, 'play');
  if (parts) await loadRecord(new File(parts, record));
}
export const giveUp = (): void => void (fetching.value = null);
