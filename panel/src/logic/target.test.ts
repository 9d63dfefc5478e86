import { describe, expect, it } from 'vitest';
import { ghostOf, question, sampleAt, type Target, withJoint, withTool } from './target';
import { fromFixedXyz } from './pose';
import type { PreviewJson, RobotModel } from './types';

const model = {
  kind: 'palletizer',
  task: 'pose',
  takes_speed: true,
  joints: [
    { name: 'a', kind: 'revolute', lower_rad: -1, upper_rad: 1 },
    { name: 'b', kind: 'revolute', lower_rad: 0, upper_rad: 2 },
    { name: 'c', kind: 'revolute', lower_rad: 0, upper_rad: 2 },
  ],
  geometry: {
    base_height_m: 0.1,
    shoulder_offset_m: 0,
    upper_arm_m: 0.1,
    forearm_m: 0.1,
    tool_offset_m: 0,
    base_front_rad: 0,
    radius_min_m: 0,
  },
} as unknown as RobotModel;

const target: Target = {
  robot: 'max',
  by: 'joints',
  joints: [0, 1, 1],
  tool: { p: [0, -0.1, 0.1], q: [1, 0, 0, 0] },
  turned: false,
};
const way = { line: false, speed: 1 };

describe('targets', () => {
  it('keep a joint inside its limits, and know at once where its tool goes', () => {
    const moved = withJoint(target, model, 0, 5);
    expect(moved.joints).toEqual([1, 1, 1]);
    expect(moved.tool.p).not.toEqual(target.tool.p);
    expect(question(moved, way, model)).toEqual({ joints: [1, 1, 1] });
  });

  it('ask for an attitude only where somebody has turned the handle', () => {
    const shifted = withTool(target, { p: [0.1, 0, 0.1], q: [1, 0, 0, 0] });
    expect(question(shifted, way, model)).toEqual({ tool: [0.1, 0, 0.1] });
    const turned = withTool(shifted, { p: [0.1, 0, 0.1], q: fromFixedXyz([0, 0, 0.3]) });
    expect(question(turned, { line: true, speed: 0.5 }, model)).toMatchObject({ line: true, speed: 0.5 });
    expect(question(turned, way, model).tool).toHaveLength(7);
    expect(question(turned, way, { ...model, task: 'pitch_roll' }).tool).toHaveLength(3);
  });

  it('say no speed to a device that hears none', () => {
    expect(question(target, { line: false, speed: 0.5 }, { ...model, takes_speed: false })).toEqual({
      joints: [0, 1, 1],
    });
  });

  it('show the ghost where the server says, red and where it was asked for otherwise', () => {
    const preview = {
      to: { positions: [0.1, 1, 1], tool: [1, 2, 3, 1, 0, 0, 0] },
    } as PreviewJson;
    expect(ghostOf(target, { kind: 'fine', preview })).toMatchObject({
      joints: [0.1, 1, 1],
      refused: false,
    });
    expect(ghostOf(target, { kind: 'refused', sentence: '', data: null })).toMatchObject({
      joints: [0, 1, 1],
      refused: true,
    });
  });

  it('find the sample of a time', () => {
    const preview = {
      samples: {
        t_s: [0, 1, 2],
        position_rad: [[0], [1], [2]],
        tool: [0, 1, 2].map((x) => [x, 0, 0, 1, 0, 0, 0]),
      },
    } as unknown as PreviewJson;
    expect(sampleAt(preview, 1.5)!.joints).toEqual([1]);
    expect(sampleAt(preview, 99)!.platform.p[0]).toBe(2);
    expect(sampleAt(preview, -1)!.joints).toEqual([0]);
  });
});
