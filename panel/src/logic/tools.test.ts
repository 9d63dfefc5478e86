import { describe, expect, it } from 'vitest';
import models from './models.fixture.json';
import { toolsOf } from './tools';
import type { RobotModel } from './types';

const named = (id: string) => Object.values(models as unknown as Record<string, RobotModel>).find((one) => one.robot === id)!;
const words = (id: string) => toolsOf(named(id)).map((tool) => tool.word);

describe('tools', () => {
  it('are those that the robot has', () => {
    expect(words('learm')).toEqual(['jaws']);
    expect(words('bigrobotarm')).toContain('gripper');
    expect(words('maxarm')).toEqual(['suction', 'nozzle']);
    expect(words('hexapod')).toEqual([]);
  });

  it('say rows with units, within what the jaws can', () => {
    const jaws = toolsOf(named('learm'))[0]!;
    expect(jaws.row(jaws.amount!.text(0.0123))).toBe('jaws 12.3mm');
    expect(jaws.amount!.text(-1)).toBe('0.0mm');
    expect(jaws.amount!.of(jaws.amount!.text(9))).toBeCloseTo(jaws.amount!.initial, 4);
    const nozzle = toolsOf(named('maxarm'))[1]!;
    expect(nozzle.row(nozzle.amount!.text(Math.PI / 4))).toBe('nozzle 45.0deg time=1s');
    expect(nozzle.amount!.of('45.0deg')).toBeCloseTo(Math.PI / 4, 9);
    expect(nozzle.amount!.of('on')).toBeUndefined();
  });
});
