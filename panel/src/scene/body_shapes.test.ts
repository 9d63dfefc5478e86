import { describe, expect, it } from 'vitest';
import fixture from '../logic/models.fixture.json';
import { linkPoses } from '../logic/kinematics';
import { compose } from '../logic/pose';
import type { Pose, RobotModel, Vec3 } from '../logic/types';
import { drawnShapes } from './body_shapes';

const model = (robot: string): RobotModel =>
  ({ ...Object.values(fixture).find((one) => one.robot === robot), shapes: [] }) as unknown as RobotModel;

const at = (poses: Pose[], link: number, p: Vec3): Vec3 => compose(poses[link]!, { p, q: [1, 0, 0, 0] }).p;

describe('bars of a body without shapes', () => {
  it('are those of its file where it has some', () => {
    const own = Object.values(fixture)[0] as unknown as RobotModel;
    expect(drawnShapes(own)).toBe(own.shapes);
  });

  it('hang together from the base to the flange, however the joints stand', () => {
    for (const robot of ['learm', 'robot-arm-2']) {
      const arm = model(robot);
      const bars = drawnShapes(arm);
      expect(bars.length).toBeGreaterThan(2);
      const q = arm.joints.map((_, i) => 0.3 + 0.2 * i);
      const poses = linkPoses(arm, q);
      let end: Vec3 = [0, 0, 0];
      for (const bar of bars) {
        const from = at(poses, bar.link, bar.from_m!);
        for (const k of [0, 1, 2]) expect(from[k]).toBeCloseTo(end[k]!, 9);
        end = at(poses, bar.link, bar.to_m!);
      }
    }
  });

  it('lead from the shoulder over the elbow to the wrist of a palletizer', () => {
    const arm = model('maxarm');
    const [stand, upper, fore] = drawnShapes(arm);
    const poses = linkPoses(arm, [1, 1.5, 0.2]);
    const shoulder = at(poses, 2, [0, 0, 0]);
    const top = at(poses, stand!.link, stand!.to_m!);
    const elbow = at(poses, upper!.link, upper!.to_m!);
    for (const k of [0, 1, 2]) {
      expect(top[k]).toBeCloseTo(shoulder[k]!, 9);
      expect(at(poses, fore!.link, fore!.from_m!)[k]).toBeCloseTo(elbow[k]!, 9);
    }
  });
});
