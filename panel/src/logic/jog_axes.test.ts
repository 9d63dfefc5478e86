import { describe, expect, it } from 'vitest';
import { jogAxes, jogFrames, jogKey, stepRow } from './jog_axes';
import type { RobotModel } from './types';

const arm = {
  kind: 'serial',
  task: 'pitch_roll',
  takes_speed: true,
  joints: [{ name: 'base', kind: 'revolute', lower_rad: -1, upper_rad: 1, velocity_max_rad_s: 2 }],
  jog: { joint: 1, base: 5, tool: 5 },
} as unknown as RobotModel;
const big = { ...arm, task: 'approach', jog: {}, takes_speed: false } as RobotModel;
const legs = {
  ...arm,
  kind: 'hexapod',
  task: 'pose',
  joints: [{ name: 'leg1', kind: 'prismatic', lower_m: 0.2, upper_m: 0.3, velocity_max_m_s: 0.01 }],
} as unknown as RobotModel;

describe('axes', () => {
  it('are the joints, or what the tool of this robot can do', () => {
    expect(jogAxes(arm, 'joint')).toEqual([{ name: 'base', measure: 'angle', speed: 2 }]);
    expect(jogAxes(arm, 'tool').map((one) => one.name)).toEqual(['x', 'y', 'z', 'pitch', 'roll']);
    expect(jogAxes(legs, 'base').map((one) => one.name)).toHaveLength(5);
  });
  it('come in the frames that a jog has, or a step', () => {
    expect(jogFrames(arm)).toEqual(['joint', 'base', 'tool']);
    expect(jogFrames(big)).toEqual(['joint', 'base', 'tool']);
    expect(jogFrames({ ...big, task: 'point' } as RobotModel)).toEqual(['joint', 'base']);
  });
});

describe('steps', () => {
  it('are rows of a program', () => {
    const [base] = jogAxes(arm, 'joint');
    expect(stepRow(arm, 'joint', base!, -Math.PI / 180, 0.25)).toBe('joint d.base=-1deg speed=25%');
    expect(stepRow(big, 'joint', base!, Math.PI / 36, 0.25)).toBe('joint d.base=5deg');
    const [x, , , pitch] = jogAxes(arm, 'tool');
    expect(stepRow(arm, 'base', x!, 0.01, 1)).toBe('line dx=10mm');
    expect(stepRow(arm, 'tool', pitch!, Math.PI / 180, 1)).toBe('line frame=tool dpitch=1deg');
    expect(stepRow(legs, 'joint', jogAxes(legs, 'joint')[0]!, 0.0001, 1)).toBe('joint d.leg1=0.1mm');
  });
});

describe('keys', () => {
  const tool = jogAxes(legs, 'base').concat({ name: 'rz', measure: 'angle', speed: 1 });
  it('are the usual set', () => {
    expect(jogKey('ArrowUp', false, tool, 'base', 0)).toEqual({ axis: 1, sign: 1 });
    expect(jogKey('PageDown', false, tool, 'tool', 0)).toEqual({ axis: 2, sign: -1 });
    expect(jogKey('ArrowLeft', false, jogAxes(arm, 'joint'), 'joint', 3)).toEqual({ axis: 3, sign: -1 });
    expect(jogKey(' ', false, tool, 'base', 0)).toBeNull();
  });
  it('turn with Shift, as far as the tool does', () => {
    expect(jogKey('ArrowRight', true, tool, 'base', 0)).toEqual({ axis: 3, sign: 1 });
    expect(jogKey('PageDown', true, tool, 'base', 0)).toEqual({ axis: 5, sign: -1 });
    const five = jogAxes(arm, 'tool');
    expect(jogKey('ArrowUp', true, five, 'tool', 0)).toEqual({ axis: 3, sign: 1 });
    expect(jogKey('ArrowLeft', true, five, 'tool', 0)).toEqual({ axis: 4, sign: -1 });
    expect(jogKey('PageUp', true, five, 'tool', 0)).toBeNull();
  });
});
