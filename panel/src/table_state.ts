/** Of the camera view: where baskets are dragged to, which cubes can be had, and where cubes could be had. */
import { batch, computed, effect, signal } from '@preact/signals';
import { atWork, model, robot, status, store } from './app';
import { basket, camera, open, shot } from './camera_state';
import { errorSentence, refusalSentence } from './i18n';
import { ConnectionError } from './logic/rpc';
import { wordsOf } from './logic/row_kinds';
import type { BasketJson, CubeReachJson, CubeVerdictJson, ErrorJson, Quat } from './logic/types';

const kAskMs = 1000;
const kReachMs = 700;

/** A basket on its way, until the cell says that it is there. */
export const dragged = signal<BasketJson | null>(null);
/** What came of the last move: robots that do not reach it, or why it stayed. */
export const basketNote = signal<{ what: 'stays' | 'far' | 'unsaved' | 'unanswered'; lines: string[] } | null>(null);

export const showsReach = signal(false);
export const reach = signal<CubeReachJson | null>(null);
export const verdicts = signal<CubeVerdictJson[]>([]);

/** Whether the robot's tool takes cubes. */
export const takesCubes = computed(() => model.value !== null && wordsOf(model.value).includes('pick'));

export const turned = (turn: number): Quat => [Math.cos(turn / 2), 0, 0, Math.sin(turn / 2)];
export const turnOf = ({ quaternion_wxyz: q }: BasketJson): number => 2 * Math.atan2(q[3], q[0]);

export async function moveBasket(to: BasketJson): Promise<void> {
  dragged.value = to;
  try {
    const moved = await store.call<{ basket: BasketJson; warnings: { robot: string; error: ErrorJson }[] }>('basket.move', {
      basket: to.name,
      x_m: to.x_m,
      y_m: to.y_m,
      turn_rad: turnOf(to),
    });
    settle(moved.basket);
    basketNote.value = moved.warnings.length > 0 ? { what: 'far', lines: moved.warnings.map((one) => `${one.robot}: ${errorSentence(one.error)}`) } : null;
  } catch (error) {
    if (error instanceof ConnectionError) {
      basketNote.value = { what: 'unanswered', lines: [] };
      return;
    }
    // It counts until the server ends, and says so: it could not be written.
    const counts = (error as { data?: { code?: string } }).data?.code === 'disk';
    if (counts) settle(to);
    basketNote.value = { what: counts ? 'unsaved' : 'stays', lines: [refusalSentence(error as Error)] };
  } finally {
    dragged.value = null;
  }
}

/** The page has it at once, not with the next picture. */
function settle(moved: BasketJson): void {
  const put = (all: BasketJson[] | undefined) => all?.map((one) => (one.name === moved.name ? moved : one));
  batch(() => {
    const cell = store.cell.peek();
    if (cell) store.cell.value = { ...cell, baskets: put(cell.baskets) };
    const seen = shot.peek();
    if (seen) shot.value = { ...seen, baskets: put(seen.baskets) };
  });
}

/** Stays as it is where a picture says again where the basket stands. */
const basketName = computed(() => basket.value?.name);
effect(() => {
  void basketName.value;
  basketNote.value = null;
});

/** What the verdicts are about: they are asked for anew where it changes. */
const subject = computed(() => {
  const cubes = (shot.value?.cubes ?? []).filter((one) => one.x_m !== undefined && !one.in_basket);
  const places = cubes.map((one) => [one.color, ...[one.x_m!, one.y_m!, one.z_m!].map((x) => Math.round(200 * x))].join());
  const joints = (status.value?.joints ?? []).map((one) => Math.round(30 * (one.position_rad ?? one.position_m ?? 0)));
  return cubes.length > 0 ? [robot.value, camera.value?.name, places.sort().join(' '), joints.join()].join(';') : '';
});

effect(() => {
  if (!open.value || !takesCubes.value || camera.value?.lens === undefined) {
    verdicts.value = [];
    return;
  }
  const asked = { robot: robot.value!, camera: camera.value.name };
  let about = '';
  let under = false;
  const ask = async () => {
    const now = subject.peek();
    if (under || atWork.peek() || now === about) return;
    under = true;
    try {
      const told = await store.call<{ cubes?: CubeVerdictJson[] }>('robot.cubes', asked);
      if (robot.peek() === asked.robot) verdicts.value = told.cubes ?? [];
      about = now;
    } catch {
      // Not known where it stands: nothing can be said of cubes yet.
      verdicts.value = [];
    } finally {
      under = false;
    }
  };
  const timer = setInterval(() => void ask(), kAskMs);
  void ask();
  return () => clearInterval(timer);
});

/** Of the camera that is shown; they stay as they are where the cell describes itself again. */
const cubeEdge = computed(() => camera.value?.cube_m);
const tableHeight = computed(() => camera.value?.table.z_m);

effect(() => {
  if (!open.value || !showsReach.value || !takesCubes.value) {
    reach.value = null;
    return;
  }
  const asked = { robot: robot.value!, edge_m: cubeEdge.value, z_m: tableHeight.value };
  let under = false;
  const ask = async () => {
    if (under || reach.peek()?.done === 1) return;
    under = true;
    try {
      const told = await store.call<CubeReachJson>('robot.cube_reach', asked);
      if (robot.peek() === asked.robot && showsReach.peek()) reach.value = told;
    } catch {
      // The page says itself that the connection is gone.
    } finally {
      under = false;
    }
  };
  reach.value = null;
  void ask();
  const timer = setInterval(() => void ask(), kReachMs);
  return () => clearInterval(timer);
});
