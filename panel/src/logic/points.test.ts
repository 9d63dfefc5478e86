import { describe, expect, it } from 'vitest';
import { freeName, poseOf, readPoints, takePoint, writePoints, type Point } from './points';
import fixture from './models.fixture.json';
import type { RobotModel, RobotStatus } from './types';

const models = fixture as unknown as RobotModel[] | Record<string, RobotModel>;
const model = Object.values(models).find((one) => (one as RobotModel).robot === 'learm') as RobotModel;
const deg = Math.PI / 180;

describe('points.toml', () => {
  it('comes back as it was written, joints, legs and places', () => {
    const points: Point[] = [
      { name: 'ready', joints: [10 * deg, 20 * deg, 0, 0, 0], source: 'say "hi" \\ # no remark', taughtAt: '2026-11-21T10:00:00Z' },
      { name: 'bin', place: { x: 0.24, y: 0.02, z: 0.2, turns: { pitch: 100 * deg, roll: 0 } } },
    ];
    const text = writePoints('learm', points, ['angle']);
    expect(text).toContain('joints_deg = [10, 20, 0, 0, 0]');
    const back = readPoints(text);
    expect(back.complaints).toEqual([]);
    expect(back.points.map((one) => one.robot)).toEqual(['learm', 'learm']);
    expect(back.points[0]!.point.source).toBe('say "hi" \\ # no remark');
    expect(back.points[0]!.point.joints![0]).toBeCloseTo(10 * deg, 9);
    expect(back.points[1]!.point.place!.turns['pitch']).toBeCloseTo(100 * deg, 9);
    const legs = readPoints(writePoints('hexapod', [{ name: 'up', joints: [0.25, 0.251, 0.25, 0.25, 0.25, 0.25] }], Array<'length'>(6).fill('length')));
    expect(legs.points[0]!.point.joints![1]).toBeCloseTo(0.251, 9);
    const both = writePoints('scara', [{ name: 'up', joints: [10 * deg, 0.0805] }], ['angle', 'length']);
    expect(both).toContain('joints = ["10deg", "80.5mm"]');
    expect(readPoints(both).points[0]!.point.joints![1]).toBeCloseTo(0.0805, 9);
    expect(readPoints('[points.a]\nrobot = "scara"\njoints = ["10deg", "80"]\n').complaints).toHaveLength(1);
  });

  it('is complained of with its line where it says something else', () => {
    const file = readPoints('[points.a]\nrobot = "learm"\nspeed = 3\njoints_deg = [1, two]\n[other]\n');
    expect(file.complaints.map((one) => one.line)).toEqual([3, 4, 5]);
  });
});

describe('a taught point', () => {
  const joints = model.joints.map((one) => ({ name: one.name, quality: 'measured', position_rad: 0.1 }));
  const status = { robot: 'left', state: 'ready', position: 'measured', joints } as unknown as RobotStatus;

  it('is where the arm is', () => {
    const taken = takePoint('a', model, status, new Date(0));
    expect(taken).toMatchObject({ name: 'a', joints: [0.1, 0.1, 0.1, 0.1, 0.1], taughtAt: '1970-01-01T00:00:00Z' });
    expect(poseOf(taken as Point, model)).toHaveLength(6);
  });

  it('is none while it moves, nobody knows where it is, or a joint is outside', () => {
    expect(takePoint('a', model, { ...status, state: 'moving' }, new Date())).toEqual({ wrong: 'moving' });
    expect(takePoint('a', model, { ...status, position: 'lost' }, new Date())).toEqual({ wrong: 'unknown' });
    const far = { ...status, joints: status.joints.map((one) => ({ ...one, position_rad: 2 })) };
    expect(takePoint('a', model, far, new Date())).toEqual({ wrong: 'outside', joint: 'base' });
  });

  it('has a name that no other has', () => {
    expect(freeName('point', [])).toBe('point');
    expect(freeName('point1', ['point1', 'point2'])).toBe('point3');
  });
});
