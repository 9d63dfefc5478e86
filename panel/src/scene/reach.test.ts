import { describe, expect, it } from 'vitest';
import { toolPose } from '../logic/kinematics';
import fixture from '../logic/models.fixture.json';
import { jointLimits } from '../logic/store';
import type { RobotModel } from '../logic/types';
import { outline, reachShell } from './reach';

const models = fixture as unknown as Record<string, RobotModel>;

describe('the shell of what is reached', () => {
  it('has a hole where a robot does not reach up to its base', () => {
    expect(outline(models['arm']!).hole).toBeNull();
    for (const name of ['learm', 'big', 'max']) expect(outline(models[name]!).hole, name).not.toBeNull();
  });
  it('.. with no place in it that is reached', () => {
    for (const name of ['learm', 'big']) {
      const model = models[name]!;
      const { centre, hole } = outline(model);
      const range = model.joints.map(jointLimits);
      for (let n = 0; n < 4000; ++n) {
        // Spread evenly, and the same each time.
        const q = range.map(({ home, lower, upper }, i) => {
          const share = [null, 0.7548, 0.5698, 0.4302, null][i] ?? null;
          return share === null ? home : lower + (upper - lower) * ((n * share) % 1);
        });
        const { p } = toolPose(model, q);
        const r = Math.hypot(p[0], p[1]);
        const at = Math.round(((Math.atan2(p[2] - centre, r) + Math.PI / 2) / Math.PI) * (hole!.length - 1));
        const [inner, height] = hole![at]!;
        expect(Math.hypot(r, p[2] - centre), name).toBeGreaterThan(Math.hypot(inner, height - centre) - 0.02);
      }
    }
  });
  it('is the documented one of the MaxArm', () => {
    const { rim, hole } = outline(models['max']!);
    const radii = [...rim, ...hole!].map(([r]) => r);
    expect(Math.min(...radii)).toBeGreaterThan(0.04);
    expect(Math.max(...radii)).toBeCloseTo(0.2913, 2);
  });
  it('is all numbers, and small enough', () => {
    for (const model of Object.values(models)) {
      const { points, faces, row } = reachShell(model);
      expect(points.flat().every(Number.isFinite), model.robot).toBe(true);
      expect(points.length % row).toBe(0);
      expect(faces.length).toBeLessThan(15_000);
    }
  });
});
