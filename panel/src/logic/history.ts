/** What the status messages of the last minutes said, kept for plots; nothing here touches the page. */
import { measuredOf } from './store';
import type { RobotStatus } from './types';

export interface JointFrame {
  /** rad or m; NaN where nobody knows. */
  position: number;
  /** What the controller asks of it, rad or m; NaN where it asks nothing. */
  commanded: number;
  /** The position is a sensor's, not the command itself. */
  measured: boolean;
}

export interface RobotFrame {
  /** Its own loop's time, s: what its motions are planned in, and derived over. */
  at: number;
  /** How much faster that runs than ours; 1 where nothing is said. */
  scale?: number;
  /** s: the longest of its control loop's last cycles. */
  cycle?: number;
  joints: JointFrame[];
}

export interface Frame {
  /** s, the same for all robots: when it came, by this page's clock that only goes on; in a record the record's own. */
  t: number;
  robots: Record<string, RobotFrame>;
  /** Of the last question and its answer, ms. */
  roundTrip?: number;
}

export const kKeptSeconds = 310;
const kFramesMax = 40_000;

const known = (value: number | undefined): number => value ?? NaN;

/**
 * @param arrived  s, of a clock that only goes on
 * @param scales   by robot: each has a clock of its own, which may run faster
 */
export function frameOf(
  all: readonly RobotStatus[],
  arrived: number,
  scales: Readonly<Record<string, number>> = {},
  roundTrip?: number,
): Frame {
  const robots: Record<string, RobotFrame> = {};
  for (const one of all) {
    robots[one.robot] = {
      at: one.at_s,
      scale: scales[one.robot] ?? 1,
      cycle: one.cycle?.longest_s,
      joints: one.joints.map((joint) => ({
        position: joint.quality === 'lost' ? NaN : known(measuredOf(joint)),
        commanded: known(joint.commanded_rad ?? joint.commanded_m),
        measured: joint.quality === 'measured',
      })),
    };
  }
  return { t: arrived, robots, roundTrip };
}

export class History {
  private all: Frame[] = [];

  get frames(): readonly Frame[] {
    return this.all;
  }
  get last(): number {
    return this.all.at(-1)?.t ?? 0;
  }

  /** @return  it was new: a robot's own time has gone on. The same status told twice is not. */
  add(frame: Frame): boolean {
    const last = this.all.at(-1);
    const robots = Object.entries(frame.robots);
    if (!Number.isFinite(frame.t) || robots.length === 0) return false;
    const step = ([name, now]: [string, RobotFrame]) => now.at - (last?.robots[name]?.at ?? -Infinity);
    // Another life of the controller begins to count anew.
    if (last && robots.some((one) => step(one) < 0)) this.all = [];
    else if (last && (frame.t <= last.t || robots.every((one) => !(step(one) > 0)))) return false;
    this.all.push(frame);
    const stale = this.all.findIndex((one) => one.t >= frame.t - kKeptSeconds);
    // In lumps, so that not every frame moves all the others.
    const drop = Math.max(stale, this.all.length - kFramesMax);
    if (drop > 250) this.all.splice(0, drop);
    return true;
  }

  clear(): void {
    this.all = [];
  }
}

/** Those from low to high, and one beyond each end where there is one, so that lines leave the picture. */
export function between(frames: readonly Frame[], low: number, high: number): readonly Frame[] {
  const at = (t: number): number => {
    let a = 0;
    let b = frames.length;
    while (a < b) {
      const middle = (a + b) >> 1;
      if (frames[middle]!.t < t) a = middle + 1;
      else b = middle;
    }
    return a;
  };
  return frames.slice(Math.max(0, at(low) - 1), Math.min(frames.length, at(high) + 1));
}
