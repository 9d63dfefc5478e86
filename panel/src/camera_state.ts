/** What the camera view shows: a cell's newest picture, and the cubes in it. */
import { batch, computed, effect, signal } from '@preact/signals';
import { robot, route, store } from './app';
import { t } from './i18n';
import { pickRow, placeRow, sameCube, sortRows } from './logic/camera';
import type { Lens } from './logic/lens';
import { fromFlat } from './logic/pose';
import type { CameraShot, CameraTrouble, CellCamera, SeenCubeJson } from './logic/types';

const kLookMs = 400;
/** Beside the 3D view: pictures come when a program looks. */
const kLookOnMs = 700;
const kBesidePx = 320;

export const shot = signal<CameraShot | null>(null);
/** The newest picture that came, as an address for an image. */
export const picture = signal<string | null>(null);
/** Its name; the first one where none was chosen. */
export const chosenCamera = signal<string | null>(null);
/** Of the cubes of `shot`. */
export const chosenCube = signal<number | null>(null);

export const cameras = computed(() => store.cell.value?.cameras ?? []);
export const camera = computed(() => cameras.value.find((one) => one.name === chosenCamera.value) ?? cameras.value[0] ?? null);
/** Where a camera on an arm was when it took the newest picture; any other hangs where its calibration says. */
function withPose(one: CellCamera): Lens | null {
  const pose = (one.on_arm && one.name === cameraName.value && shot.value?.pose) || one.lens?.pose;
  return one.lens && pose ? { ...one.lens, pose } : null;
}
export const lenses = computed(() => cameras.value.map(withPose).filter((one) => one !== null));
export const lens = computed(() => camera.value && withPose(camera.value));
/** Where they stand by the newest picture, else as the cell was told at first. */
export const baskets = computed(() => shot.value?.baskets ?? store.cell.value?.baskets ?? []);
/** Its name; the first one where none was chosen. */
export const chosenBasket = signal<string | null>(null);
export const basket = computed(() => baskets.value.find((one) => one.name === chosenBasket.value) ?? baskets.value[0] ?? null);
/** Stays as it is where the cell describes itself again. */
export const cameraName = computed(() => camera.value?.name ?? null);

/** The calibration wizard is shown: the live picture comes with the printed tags in it. */
export const calibrating = signal(false);

const canLook = computed(() => store.connection.value === 'open' && camera.value !== null);
export const open = computed(() => route.value.view === 'camera' && canLook.value);
/** A program runs: what it sees is shown beside the 3D view, and takes no pictures of its own. */
export const looksOn = computed(
  () => route.value.view !== 'camera' && canLook.value && Object.values(store.status.value).some((one) => one.job && !one.job.over),
);

effect(() => {
  void cameraName.value;
  batch(() => {
    shot.value = null;
    picture.value = null;
    chosenCube.value = null;
  });
});
effect(() => {
  const inView = open.value;
  if (!inView && !looksOn.value) return;
  const name = camera.value!.name;
  const params = () => (!inView ? { take: false, longest_px: kBesidePx } : calibrating.peek() ? { tags: true } : {});
  let under = false;
  const look = async () => {
    if (under) return;
    under = true;
    try {
      const known = shot.peek()?.number ?? 0;
      const next = await store.call<CameraShot>('camera.look', { camera: name, known, ...params() });
      if (camera.peek()?.name === name) take(next);
    } catch {
      // The page says itself that the connection is gone.
    } finally {
      under = false;
    }
  };
  void look();
  const timer = setInterval(() => void look(), inView ? kLookMs : kLookOnMs);
  return () => clearInterval(timer);
});

function take(next: CameraShot): void {
  if (next.number === 0) return;
  if (next.number === shot.peek()?.number) return;
  const chosen = chosenCube.peek() === null ? undefined : shot.peek()?.cubes?.[chosenCube.peek()!];
  batch(() => {
    shot.value = next;
    if (next.picture) picture.value = `data:image/jpeg;base64,${next.picture}`;
    chosenCube.value = chosen ? sameCube(chosen, next.cubes ?? []) : null;
  });
}

/** Lets something happen to a simulated camera, to see what robots make of it. */
export async function disturb(trouble: CameraTrouble): Promise<void> {
  if (!shot.value || !camera.value) return;
  const before = shot.value;
  shot.value = { ...before, trouble };
  const done = await store.ask('simulation.camera', { camera: camera.value.name, trouble });
  if (!done && shot.value?.number === before.number) shot.value = before;
}

/** Where the robot that is chosen stands. */
const base = () => {
  const place = store.cell.value?.robots.find((one) => one.name === robot.value);
  return place ? fromFlat(place.pose) : null;
};

export function pick(cube: SeenCubeJson, intoBasket: boolean): void {
  const from = base();
  if (!from || !robot.value) return;
  const rows = [pickRow(from, cube)];
  if (intoBasket && basket.value) rows.push(placeRow(basket.value.name));
  void store.run(robot.value, `${rows.join('\n')}\n`, t('camera.job.pick'));
}

export function sort(color: string | null): void {
  if (!robot.value || !basket.value) return;
  void store.run(robot.value, `${sortRows(basket.value.name, color)}\n`, t('camera.job.sort'));
}
