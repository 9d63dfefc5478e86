/**
 * What somebody has prepared for each robot: its target and the way there. This browser keeps it, so that it is there
 * again behind another robot, a reload and a restart. Nothing moves by that: it is previewed anew.
 */
import type { Kept } from './shelf';
import { jointLimits } from './store';
import type { Target, Way } from './target';
import type { Pose, RobotModel } from './types';
import { clamp } from './units';

export interface Aim {
  way: Way;
  target: Target | null;
}

export const kAimsKey = 'sinew.targets';
const kVersion = 1;
const kRobotsMax = 32;
const kTextMax = 200_000;
/** A handle that is dragged changes it with every picture; a disk need not hear of each. */
const kWaitMs = 300;

interface Row {
  robot: string;
  /** What kind of robot it was made for. */
  kind: string;
  way: Way;
  target: Omit<Target, 'robot'> | null;
}

export class Aims {
  /** Of this page; what of it is not written yet. */
  private readonly mine = new Map<string, Row>();
  private readonly waiting = new Set<string>();
  private timer: unknown = null;

  constructor(
    private readonly kept: Kept,
    private readonly setTimer: (callback: () => void, ms: number) => unknown = (f, ms) => setTimeout(f, ms),
  ) {}

  put(robot: string, model: RobotModel, { way, target }: Aim): void {
    const { robot: _, ...rest } = target ?? { robot };
    this.mine.set(robot, { robot, kind: model.robot, way, target: target ? (rest as Omit<Target, 'robot'>) : null });
    this.waiting.add(robot);
    this.timer ??= this.setTimer(() => this.flush(), kWaitMs);
  }

  /** Now: the page may go. Rows that other pages have written meanwhile stay. */
  flush(): void {
    this.timer = null;
    if (this.waiting.size === 0) return;
    const others = this.rows().filter((one) => !this.waiting.has(one.robot));
    const rows = [...others, ...[...this.waiting].map((one) => this.mine.get(one)!)].slice(-kRobotsMax);
    this.waiting.clear();
    try {
      this.kept.setItem(kAimsKey, JSON.stringify({ version: kVersion, rows }));
    } catch {
      // A browser may have no room, or refuse: it is there as long as the page is.
    }
  }

  /** Nothing where there is none, or what there is was made for another kind of robot. */
  load(robot: string, model: RobotModel): Aim | null {
    const row = this.mine.get(robot) ?? this.rows().find((one) => one.robot === robot);
    if (row?.kind !== model.robot) return null;
    return { way: row.way, target: row.target && inside({ robot, ...row.target }, model) };
  }

  private rows(): Row[] {
    try {
      const text = this.kept.getItem(kAimsKey) ?? '';
      if (text === '' || text.length > kTextMax) return [];
      const read = JSON.parse(text) as { version?: unknown; rows?: unknown };
      return read.version === kVersion && Array.isArray(read.rows) ? read.rows.flatMap(rowOf) : [];
    } catch {
      return [];
    }
  }
}

/** What is asked for stays inside the limits, which may have changed since. */
function inside(target: Target, model: RobotModel): Target | null {
  if (target.joints.length !== model.joints.length) return null;
  const joints = target.joints.map((value, i) => {
    const { lower, upper } = jointLimits(model.joints[i]!);
    return clamp(value, lower, upper);
  });
  return { ...target, joints };
}

const numbers = (value: unknown, count?: number): value is number[] =>
  Array.isArray(value) && (count === undefined || value.length === count) && value.every((one) => Number.isFinite(one));

/** What somebody else may have written there is looked at, not believed. */
function rowOf(json: unknown): Row[] {
  const { robot, kind, way, target } = (json ?? {}) as Partial<Row>;
  if (typeof robot !== 'string' || typeof kind !== 'string') return [];
  if (typeof way?.line !== 'boolean' || !(way.speed > 0 && way.speed <= 1)) return [];
  const row: Row = { robot, kind, way: { line: way.line, speed: way.speed }, target: null };
  const tool = target?.tool as Partial<Pose> | undefined;
  if (!target || (target.by !== 'joints' && target.by !== 'tool') || !numbers(target.joints)) return [row];
  if (!numbers(tool?.p, 3) || !numbers(tool?.q, 4) || Math.abs(Math.hypot(...tool.q) - 1) > 1e-3) return [row];
  row.target = { by: target.by, joints: target.joints, tool: { p: tool.p, q: tool.q }, turned: target.turned === true };
  return [row];
}
