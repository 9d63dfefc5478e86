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
  /** Its own loop's time, s. */
  at: number;
  joints: JointFrame[];
}

export interface Frame {
  /** Of the controller, s: the latest of its robots. */
  t: number;
  robots: Record<string, RobotFrame>;
  /** When it came, s of this page's clock. */
  arrived?: number;
  /** Of the last question and its answer, ms. */
  roundTrip?: number;
}

export const kKeptSeconds = 310;
const kFramesMax = 40_000;

const known = (value: number | undefined): number => value ?? NaN;

export function frameOf(all: readonly RobotStatus[], arrived?: number, roundTrip?: number): Frame {
  const robots: Record<string, RobotFrame> = {};
  for (const one of all) {
    robots[one.robot] = {
      at: one.at_s,
      joints: one.joints.map((joint) => ({
        position: joint.quality === 'lost' ? NaN : known(measuredOf(joint)),
        commanded: known(joint.commanded_rad ?? joint.commanded_m),
        measured: joint.quality === 'measured',
      })),
    };
  }
  return { t: Math.max(...all.map((one) => one.at_s)), robots, arrived, roundTrip };
}

export class History {
  private all: Frame[] = [];

  get frames(): readonly Frame[] {
    return this.all;
  }
  get last(): number {
    return this.all.at(-1)?.t ?? 0;
  }

  /** @return  it was new; the same status told twice is not */
  add(frame: Frame): boolean {
    if (!Number.isFinite(frame.t)) return false;
    const last = this.all.at(-1);
    // Another life of the controller begins to count anew.
    if (last && frame.t < last.t - 1) this.all = [];
    else if (last && frame.t <= last.t) return false;
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
