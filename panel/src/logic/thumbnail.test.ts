import { describe, expect, it } from 'vitest';
import { outline } from '../scene/reach';
import { legLengths, toolPose } from './kinematics';
import fixture from './models.fixture.json';
import { jointLimits } from './store';
import { platformAt, sketchPlace } from './thumbnail';
import { fixedXyz } from './pose';
import type { RobotModel } from './types';

const models = fixture as unknown as Record<string, RobotModel>;

describe('a thumbnail of a place', () => {
  for (const name of ['arm', 'learm', 'big', 'max']) {
    it(`of ${name} has its tool where that was, inside its picture`, () => {
      const model = models[name]!;
      const home = toolPose(model, model.joints.map((joint) => jointLimits(joint).home));
      const [rx, ry, rz] = fixedXyz(home.q);
      const [x, y, z] = home.p;
      const { rim, hole } = outline(model);
      const all = sketchPlace(model, { x, y, z, turns: { rx, ry, rz } }, hole ? [rim, hole] : [rim], 64);
      for (const dot of [...all.sideReach.flat(), ...all.topReach, all.sideTool, all.topTool, ...all.sideWay!, ...all.topWay!]) {
        for (const one of dot) expect(one).toBeGreaterThanOrEqual(-4);
        for (const one of dot) expect(one).toBeLessThanOrEqual(68);
      }
      expect(all.sideWay!.at(-1)).toEqual(all.sideTool);
    });
  }
  it('points where its words say, and nowhere without them', () => {
    const way = (turns: Record<string, number>) =>
      sketchPlace(models['learm']!, { x: 0.2, y: 0, z: 0.1, turns }, [[[0.35, 0]]], 64).sideWay;
    expect(way({})).toBeNull();
    const [from, to] = way({ pitch: Math.PI, roll: 0 })!;
    expect(to![0]).toBeCloseTo(from![0], 9);
    expect(to![1]).toBeGreaterThan(from![1]);
  });
  it('of a platform is its platform there', () => {
    const six = models['platform'] as RobotModel & { kind: 'hexapod' };
    const [x, y, z] = six.geometry.home.xyz_m;
    legLengths(six, platformAt(six, { x, y, z, turns: {} })).forEach((length, i) => {
      expect(length).toBeCloseTo(six.joints[i]!.home_m!, 6);
    });
  });
});
