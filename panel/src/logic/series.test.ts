import { describe, expect, it } from 'vitest';
import { between, frameOf, History, type Frame } from './history';
import { csvOf, derivative, linesOf, thinned, type Line, type Pick } from './series';
import type { RobotStatus } from './types';

const pick: Pick = { robot: 'arm', joint: 0, name: 'base', measure: 'angle', hue: 0 };
const names = { trip: 'trip', late: 'late' };
const frame = (t: number, position: number, commanded = position, measured = true): Frame => ({
  t,
  robots: { arm: { at: t, joints: [{ position, commanded, measured }] } },
});

describe('derivatives', () => {
  // Uneven on purpose.
  const t = Array.from({ length: 40 }, (_, i) => 0.04 * i + (i % 3) * 0.005);
  it('of a parabola are exact', () => {
    const y = t.map((one) => 1 - 2 * one + 3 * one * one);
    derivative(t, y, 1).forEach((v, i) => expect(v).toBeCloseTo(-2 + 6 * t[i]!, 6));
    derivative(t, y, 2).forEach((a) => expect(a).toBeCloseTo(6, 5));
  });
  it('leave out what nobody knows, and say nothing of too little', () => {
    const y = t.map((one, i) => (i < 20 ? NaN : 5 * one));
    const v = derivative(t, y, 1);
    expect(v[10]).toBeNaN();
    expect(v[20]).toBeCloseTo(5, 6);
    expect(derivative([0, 1, 2], [0, 1, 2], 1)[1]).toBeNaN();
    expect(derivative([1, 1, 1, 1, 1], [0, 1, 2, 3, 4], 1)[2]).toBeNaN();
  });
});

describe('lines', () => {
  it('are in degrees, and an error is the command less the measurement', () => {
    const frames = [frame(0, 0.1, 0.2), frame(0.1, 0.1, 0.3)];
    expect(linesOf(frames, [pick], 'position', names)[0]!.values[0]).toBeCloseTo(5.7296, 3);
    const error = linesOf(frames, [pick], 'error', names)[0]!;
    expect(error.unit).toBe('°');
    expect(error.values[1]).toBeCloseTo(11.459, 2);
  });
  it('have no error where the position is the command itself', () => {
    expect(linesOf([frame(0, 0.1, 0.1, false)], [pick], 'error', names)[0]!.values[0]).toBeNaN();
  });
  it('of legs are in mm', () => {
    const leg = linesOf([frame(0, 0.24)], [{ ...pick, measure: 'length' }], 'velocity', names)[0]!;
    expect(leg.unit).toBe('mm/s');
    expect(linesOf([frame(0, 0.24)], [{ ...pick, measure: 'length' }], 'position', names)[0]!.values[0]).toBeCloseTo(240);
  });
  it('tell the time between samples and what the connection adds', () => {
    const frames: Frame[] = [
      { ...frame(1, 0), t: 51, roundTrip: 2 },
      { ...frame(1.04, 0), t: 51.06, roundTrip: 3 },
    ];
    expect(linesOf(frames, [pick], 'cycle', names)[0]!.values[1]).toBeCloseTo(40);
    // A control loop that tells of its cycles is believed: what came is another thing.
    const told = frames.map((one) => ({ ...one, robots: { ...one.robots, [pick.robot]: { ...one.robots[pick.robot]!, cycle: 0.012 } } }));
    expect(linesOf(told, [pick], 'cycle', names)[0]!.values[1]).toBeCloseTo(12);
    const [trip, late] = linesOf(frames, [], 'latency', names);
    expect([...trip!.values]).toEqual([2, 3]);
    expect(late!.values[0]).toBeCloseTo(0);
    expect(late!.values[1]).toBeCloseTo(20);
  });
});

describe('thinning', () => {
  it('keeps every peak, and the order of time', () => {
    const t = Array.from({ length: 5000 }, (_, i) => i / 100);
    const values = Float64Array.from(t, (_, i) => (i === 1234 ? 9 : i === 3333 ? -7 : 0));
    const line: Line = { label: 'a', unit: 'mm', hue: 0, values };
    const thin = thinned(t, [line], 400);
    expect(thin.t.length).toBe(400);
    expect(Math.max(...thin.lines[0]!.values)).toBe(9);
    expect(Math.min(...thin.lines[0]!.values)).toBe(-7);
    for (let i = 1; i < thin.t.length; ++i) expect(thin.t[i]! > thin.t[i - 1]!).toBe(true);
  });
  it('leaves few points as they are, and gaps as gaps', () => {
    const line: Line = { label: 'a', unit: 'mm', hue: 0, values: new Float64Array([1, NaN, 3]) };
    expect([...thinned([0, 1, 2], [line], 10).lines[0]!.values]).toEqual([1, NaN, 3]);
    const none = { ...line, values: new Float64Array(1000).fill(NaN) };
    expect(thinned(Array.from({ length: 1000 }, (_, i) => i), [none], 20).lines[0]!.values.every(Number.isNaN)).toBe(true);
  });
});

describe('tables', () => {
  it('name the unit, begin at zero, and leave unknown cells empty', () => {
    const lines: Line[] = [{ label: 'arm.base', unit: '°/s', hue: 0, values: new Float64Array([1.5, NaN]) }];
    expect(csvOf([100, 100.04], [{ quantity: 'velocity', lines }])).toBe(
      't_s,arm.base.velocity_deg_s\n0.000000,1.5\n0.040000,\n',
    );
  });
  it('make no formula of a name', () => {
    const lines: Line[] = [{ label: '=cmd("x"),1', unit: 'ms', hue: 0, values: new Float64Array([1]) }];
    expect(csvOf([0], [{ quantity: 'cycle', lines }]).split('\n')[0]).toBe(`t_s,"'=cmd(""x""),1.cycle_ms"`);
  });
});

describe('history', () => {
  const status = (at: number, position?: number): RobotStatus => ({
    robot: 'arm',
    at_s: at,
    state: 'ready',
    position: position === undefined ? 'lost' : 'measured',
    connected: true,
    joints: [{ name: 'base', quality: position === undefined ? 'lost' : 'measured', position_rad: position, commanded_rad: 1 }],
    feed: 1,
    free_drive: false,
    progress: 0,
    health: {},
  });
  it('knows what was told, and nothing of a joint that is lost', () => {
    expect(frameOf([status(1, 0.5)], 9).robots['arm']!.joints[0]).toEqual({ position: 0.5, commanded: 1, measured: true });
    expect(frameOf([status(1)], 9).robots['arm']!.joints[0]!.position).toBeNaN();
  });
  it('takes each moment once, and begins anew with a new controller', () => {
    const history = new History();
    expect(history.add(frame(5, 0))).toBe(true);
    expect(history.add(frame(5, 0))).toBe(false);
    expect(history.add(frame(6, 0))).toBe(true);
    // A job's message changes a status, not when it was.
    expect(history.add({ ...frame(6, 0), t: 6.5 })).toBe(false);
    expect(history.add({ ...frame(0.5, 0), t: 7 })).toBe(true);
    expect(history.frames.length).toBe(1);
  });
  it('forgets what is older than it keeps', () => {
    const history = new History();
    for (let i = 0; i < 9000; ++i) history.add(frame(i * 0.04, 0));
    expect(history.frames[0]!.t).toBeGreaterThan(history.last - 330);
    expect(history.frames.length).toBeLessThan(8300);
  });
  it('gives what is in the picture and one beyond each end', () => {
    const frames = [0, 1, 2, 3, 4, 5].map((t) => frame(t, 0));
    expect(between(frames, 1.5, 3.5).map((one) => one.t)).toEqual([1, 2, 3, 4]);
    expect(between(frames, -3, 99).length).toBe(6);
    expect(between([], 0, 1)).toEqual([]);
  });
});

describe('robots with clocks of their own', () => {
  const scales = { arm: 1, platform: 200 };
  const of = (robot: string, at: number, position: number): RobotStatus => ({
    robot,
    at_s: at,
    state: 'moving',
    position: 'measured',
    connected: true,
    joints: [{ name: 'a', quality: 'measured', position_rad: position, commanded_rad: position }],
    feed: 1,
    free_drive: false,
    progress: 0,
    health: {},
  });
  // 50 ms apart; the fast one began long ago. Message 20 comes 30 ms late.
  const history = new History();
  for (let i = 0; i <= 40; ++i) {
    const t = 0.05 * i;
    const arrived = 1000 + t + (i === 20 ? 0.03 : 0);
    const [arm, platform] = [3 + t, 90_000 + 200 * t];
    history.add(frameOf([of('arm', arm, 0.1 * arm), of('platform', platform, 0.001 * platform)], arrived, scales));
  }
  const { frames } = history;
  const joint = (robot: string): Pick => ({ robot, joint: 0, name: 'a', measure: 'angle', hue: 0 });

  it('have one time axis: when they came', () => {
    expect(frames).toHaveLength(41);
    expect(history.last).toBeCloseTo(1002, 6);
    // The last second is the last second of both.
    expect(between(frames, history.last - 1, history.last)).toHaveLength(22);
  });

  it('have speeds in their own time', () => {
    const speed = (robot: string) => linesOf(frames, [joint(robot)], 'velocity', names)[0]!.values[30]!;
    expect(speed('arm')).toBeCloseTo(0.1 * (180 / Math.PI), 3);
    expect(speed('platform')).toBeCloseTo(0.001 * (180 / Math.PI), 3);
  });

  it('are late by our time, and their samples are as far apart as we see them', () => {
    const late = linesOf(frames, [], 'latency', names)[1]!.values;
    expect(late[10]).toBeCloseTo(0, 3);
    expect(late[20]).toBeCloseTo(30, 3);
    for (const line of linesOf(frames, [joint('arm'), joint('platform')], 'cycle', names)) {
      expect(line.values[5], line.label).toBeCloseTo(50, 3);
    }
  });

  it('are new where any of them went on, and begin anew with any of them', () => {
    const one = new History();
    const put = (arm: number, platform: number, arrived: number) => one.add(frameOf([of('arm', arm, 0), of('platform', platform, 0)], arrived, scales));
    expect(put(1, 500, 10)).toBe(true);
    expect(put(1, 508, 10.04)).toBe(true);
    expect(put(1, 508, 10.08)).toBe(false);
    expect(put(0.1, 2, 12)).toBe(true);
    expect(one.frames).toHaveLength(1);
  });
});
