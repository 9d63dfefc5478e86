import { describe, expect, it } from 'vitest';
import { legLengths, linkPoses, toolPose } from './kinematics';
import fixture from './models.fixture.json';
import { compose, fixedXyz, fromFixedXyz, fromJson, inverse } from './pose';
import { jointLimits } from './store';
import type { Pose, RobotModel } from './types';

/** robot.model of all five robots, as the server gave it. */
const models = fixture as unknown as Record<string, RobotModel>;
const home = (model: RobotModel) => model.joints.map((joint) => jointLimits(joint).home);

function apart(a: Pose, b: Pose): number {
  const off = compose(inverse(a), b);
  return Math.max(Math.hypot(...off.p), 2 * Math.hypot(off.q[1], off.q[2], off.q[3]));
}

describe('kinematics', () => {
  for (const [name, model] of Object.entries(models)) {
    it(`${name}: every link at home is where the server has it`, () => {
      const poses = linkPoses(model, home(model));
      expect(poses).toHaveLength(model.links.length);
      let compared = 0;
      model.links.forEach((link, i) => {
        if (!link.home) return;
        ++compared;
        expect(apart(poses[i]!, fromJson(link.home)), link.name).toBeLessThan(1e-9);
      });
      expect(compared).toBeGreaterThan(1);
    });
  }

  it('a chain turns about the axes of its table', () => {
    const arm = models['arm']!;
    const q = home(arm);
    const before = toolPose(arm, q);
    const after = toolPose(arm, [q[0]! + 0.5, ...q.slice(1)]);
    expect(Math.hypot(after.p[0], after.p[1])).toBeCloseTo(Math.hypot(before.p[0], before.p[1]), 12);
    expect(after.p[2]).toBeCloseTo(before.p[2], 12);
  });

  it('a palletizer never tilts its tool', () => {
    const max = models['max']!;
    for (const q of [[1, 1, 0.5], [2, 2.2, 1.4]]) {
      const [rx, ry] = fixedXyz(toolPose(max, q).q);
      expect(Math.abs(rx) + Math.abs(ry)).toBeLessThan(1e-12);
    }
  });

  it('a platform has the legs that its pose needs', () => {
    const six = models['platform'] as RobotModel & { kind: 'hexapod' };
    legLengths(six, fromJson(six.geometry.home)).forEach((length, i) => {
      expect(length).toBeCloseTo(home(six)[i]!, 6);
    });
  });
});

describe('rotations', () => {
  it('come back from their fixed angles', () => {
    for (const angles of [[0.1, -0.4, 2.9], [-3, 1.2, 0], [0, Math.PI / 2, 0.3]] as const) {
      const back = fromFixedXyz(fixedXyz(fromFixedXyz([...angles])));
      expect(apart({ p: [0, 0, 0], q: back }, { p: [0, 0, 0], q: fromFixedXyz([...angles]) })).toBeLessThan(1e-9);
    }
  });
});
