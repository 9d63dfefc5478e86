import { describe, expect, it } from 'vitest';
import { linkPoses, nearness } from '../logic/kinematics';
import fixture from '../logic/models.fixture.json';
import { compose } from '../logic/pose';
import { jointLimits } from '../logic/store';
import type { Pose, RobotModel, Vec3 } from '../logic/types';
import { axisFrame, Body, ghostLook } from './body';
import { limitMark } from './limits';
import { Materials } from './look';

const models = fixture as unknown as Record<string, RobotModel>;
const apart = (a: Vec3, b: Vec3): number => Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);

describe('limits that are shown', () => {
  it('of a palletizer point along its links', () => {
    const max = models['max'] as RobotModel & { kind: 'palletizer' };
    const g = max.geometry;
    for (const q of [[1, 1, 0.5], [2, 2.2, 1.4], [3.5, 1.5, 0]]) {
      const poses = linkPoses(max, q);
      const along = (joint: number, length: number): Vec3 => {
        const { pose, offset } = axisFrame(max, joint, poses)!;
        const angle = q[joint]! + offset;
        return compose(pose, { p: [length * Math.cos(angle), length * Math.sin(angle), 0], q: [1, 0, 0, 0] }).p;
      };
      expect(apart(along(1, g.upper_arm_m), poses[3]!.p)).toBeLessThan(1e-12);
      const wrist = compose(poses[3]!, { p: [0, -g.forearm_m, 0], q: [1, 0, 0, 0] }).p;
      expect(apart(along(2, g.forearm_m), wrist)).toBeLessThan(1e-12);
      const tool = poses.at(-1)!.p;
      const [x, y] = along(0, Math.hypot(tool[0], tool[1]));
      expect(apart([x, y, 0], [tool[0], tool[1], 0])).toBeLessThan(1e-12);
    }
  });
  it('are there for every joint of every robot', () => {
    const look = new Materials(true);
    for (const model of Object.values(models)) {
      const home = model.joints.map((joint) => jointLimits(joint).home);
      const poses = linkPoses(model, home);
      model.joints.forEach((joint, i) => expect(limitMark(model, i, poses, home[i]!, look), joint.name).not.toBeNull());
    }
  });
  it('come near by and by', () => {
    expect(nearness(0.27, 0.195, 0.345)).toBe(0);
    expect(nearness(0.196, 0.195, 0.345)).toBe(1);
    expect(nearness(0.4, 0.195, 0.345)).toBe(1);
    expect(nearness(0.325, 0.195, 0.345)).toBeGreaterThan(0.3);
    expect(nearness(0.325, 0.195, 0.345)).toBeLessThan(0.7);
  });
  it('colour the legs of a platform, and none of its ghost', () => {
    const six = models['platform'] as RobotModel & { kind: 'hexapod' };
    const look = new Materials(true);
    const low: Pose = { p: [0, 0, 0.172], q: [1, 0, 0, 0] };
    const used = (body: Body): unknown[] => {
      body.pose([], low);
      const all: unknown[] = [];
      body.group.traverse((one) => all.push((one as { material?: unknown }).material));
      return all;
    };
    const { shell, hub, metal, accent, near } = look;
    expect(used(new Body(six, { shell, hub, metal, accent, near })).filter((one) => one === near.at(-1))).toHaveLength(12);
    expect(used(new Body(six, ghostLook(look.ghost))).some((one) => near.includes(one as never))).toBe(false);
  });
});
