/** What somebody wants to see before it moves: where to, which way, how fast. */
import { jointLimits, type PreviewTarget } from './store';
import { linkPoses, toolPose } from './kinematics';
import { fixedXyz } from './pose';
import { clamp } from './units';
import type { Pose, PreviewJson, RefusalData, RobotModel } from './types';

export interface Target {
  robot: string;
  by: 'joints' | 'tool';
  joints: number[];
  /** Tool in base. Of a platform that is moved by its legs the last one that the server knew. */
  tool: Pose;
  /** The attitude was asked for, too. */
  turned: boolean;
}

export interface Way {
  line: boolean;
  /** Share of the joints' limits, (0, 1]. */
  speed: number;
}

export type Verdict =
  | { kind: 'checking' }
  | { kind: 'fine'; preview: PreviewJson }
  | { kind: 'refused'; sentence: string; data: RefusalData | null }
  | { kind: 'lost' };

/** A slider was dragged. What is asked for stays inside all limits, wherever the robot hangs. */
export function withJoint(target: Target, model: RobotModel, joint: number, value: number): Target {
  const joints = target.joints.map((one, i) => {
    const { lower, upper } = jointLimits(model.joints[i]!);
    return clamp(i === joint ? value : one, lower, upper);
  });
  const tool = model.kind === 'hexapod' ? target.tool : toolPose(model, joints);
  return { ...target, by: 'joints', joints, tool, turned: false };
}

/** The handle was dragged. */
export function withTool(target: Target, tool: Pose): Target {
  const same = Math.abs(tool.q.reduce((sum, one, i) => sum + one * target.tool.q[i]!, 0)) > 1 - 1e-9;
  return { ...target, by: 'tool', tool, turned: target.turned || !same };
}

/** What the server is asked; a line goes by the tool, whatever was dragged. */
export function question(target: Target, way: Way, model: RobotModel): PreviewTarget {
  const speed = way.speed < 1 && model.takes_speed ? { speed: way.speed } : {};
  if (target.by === 'joints' && !(way.line && model.kind !== 'hexapod')) {
    return { joints: target.joints, ...speed };
  }
  const whole = canTurn(model) && (target.turned || target.by === 'joints');
  const tool = whole ? [...target.tool.p, ...target.tool.q] : [...target.tool.p];
  return { tool, ...(way.line ? { line: true } : {}), ...speed };
}

/** Whether a tool can be asked for any attitude. */
export const canTurn = (model: RobotModel): boolean => model.task === 'pose' || model.task === 'yaw';

/** What the ghost shows: where the server says that it ends, or where the sliders stand. */
export function ghostOf(
  target: Target,
  verdict: Verdict,
): { joints: number[]; platform: Pose; refused: boolean } {
  const refused = verdict.kind === 'refused';
  if (verdict.kind === 'fine' && verdict.preview.to.positions && verdict.preview.to.tool) {
    const row = verdict.preview.to.tool;
    return {
      joints: verdict.preview.to.positions,
      platform: { p: [row[0], row[1], row[2]], q: [row[3], row[4], row[5], row[6]] },
      refused,
    };
  }
  return { joints: target.joints, platform: target.tool, refused };
}

/** At a time of the preview: joints and tool of the nearest sample before it. */
export function sampleAt(preview: PreviewJson, t: number): { joints: number[]; platform: Pose } | null {
  const { samples } = preview;
  const rows = samples.position_rad ?? samples.position_m ?? samples.position_rad_m ?? [];
  let low = 0;
  let high = samples.t_s.length - 1;
  if (high < 0) return null;
  while (low < high) {
    const middle = Math.ceil((low + high) / 2);
    if (samples.t_s[middle]! <= t) low = middle;
    else high = middle - 1;
  }
  const row = samples.tool[low]!;
  return {
    joints: rows[low]!,
    platform: { p: [row[0], row[1], row[2]], q: [row[3], row[4], row[5], row[6]] },
  };
}

/** Its place and turns as people read them, m and rad. */
export function toolNumbers(pose: Pose): [number, number, number, number, number, number] {
  return [...pose.p, ...fixedXyz(pose.q)];
}

export { linkPoses };
