import { describe, expect, it } from 'vitest';
import { Aims, kAimsKey } from './aims';
import type { Target } from './target';
import type { RobotModel } from './types';

const model = {
  robot: 'learm',
  joints: [
    { name: 'base', kind: 'revolute', lower_rad: -1, upper_rad: 1 },
    { name: 'shoulder', kind: 'revolute', lower_rad: 0, upper_rad: 2 },
  ],
} as unknown as RobotModel;
const target = (robot: string, joints = [0.5, 1]): Target => ({
  robot,
  by: 'tool',
  joints,
  tool: { p: [0.1, 0.2, 0.3], q: [1, 0, 0, 0] },
  turned: true,
});
const way = { line: true, speed: 0.25 };

function storage() {
  const all: Record<string, string> = {};
  return { all, getItem: (key: string) => all[key] ?? null, setItem: (key: string, value: string) => void (all[key] = value) };
}
function rig(kept = storage()) {
  const timers: (() => void)[] = [];
  return { kept, timers, aims: new Aims(kept, (callback) => timers.push(callback)) };
}

describe('a target that was prepared', () => {
  it('is there again behind another robot', () => {
    const { aims } = rig();
    aims.put('left', model, { way, target: target('left') });
    aims.put('right', model, { way: { line: false, speed: 1 }, target: null });
    expect(aims.load('right', model)).toEqual({ way: { line: false, speed: 1 }, target: null });
    expect(aims.load('left', model)).toEqual({ way, target: target('left') });
    expect(aims.load('nobody', model)).toBeNull();
  });

  it('is there again in another page, once it was written', () => {
    const { aims, kept, timers } = rig();
    aims.put('left', model, { way, target: target('left', [0, 0]) });
    aims.put('left', model, { way, target: target('left') });
    expect(kept.all[kAimsKey]).toBeUndefined();
    expect(timers).toHaveLength(1);
    timers[0]!();
    expect(rig(kept).aims.load('left', model)).toEqual({ way, target: target('left') });
    // What another page has written meanwhile stays.
    const other = rig(kept);
    other.aims.put('right', model, { way, target: target('right') });
    other.aims.flush();
    aims.put('left', model, { way, target: null });
    aims.flush();
    expect(rig(kept).aims.load('right', model)?.target).toEqual(target('right'));
    expect(rig(kept).aims.load('left', model)?.target).toBeNull();
  });

  it('is not one of another kind of robot, and stays inside limits that have changed', () => {
    const { aims } = rig();
    aims.put('left', model, { way, target: target('left', [5, -5]) });
    expect(aims.load('left', { ...model, robot: 'maxarm' })).toBeNull();
    expect(aims.load('left', model)?.target?.joints).toEqual([1, 0]);
    expect(aims.load('left', { ...model, joints: model.joints.slice(1) })?.target).toBeNull();
  });

  it('is kept of so many robots only', () => {
    const { aims, kept } = rig();
    for (let i = 0; i < 50; ++i) aims.put(`r${i}`, model, { way, target: null });
    aims.flush();
    expect(JSON.parse(kept.all[kAimsKey]!).rows).toHaveLength(32);
    const next = rig(kept).aims;
    expect(next.load('r0', model)).toBeNull();
    expect(next.load('r49', model)).not.toBeNull();
  });

  it('is none where something else stands there, and nothing breaks', () => {
    const there = { by: 'tool', joints: [0, 0], tool: { p: [0, 0, 0], q: [1, 0, 0, 0] }, turned: false };
    const good = { robot: 'left', kind: 'learm', way, target: there };
    const load = (what: unknown) => {
      const kept = storage();
      kept.all[kAimsKey] = typeof what === 'string' ? what : JSON.stringify(what);
      return rig(kept).aims.load('left', model);
    };
    expect(load({ version: 1, rows: [good] })?.target).not.toBeNull();
    expect(load('{')).toBeNull();
    expect(load('null')).toBeNull();
    expect(load({ version: 2, rows: [good] })).toBeNull();
    expect(load({ version: 1, rows: [null, 5, { robot: 'left' }] })).toBeNull();
    expect(load(' '.repeat(300_000) + JSON.stringify({ version: 1, rows: [good] }))).toBeNull();
    for (const way of [null, { line: 1, speed: 0.5 }, { line: true, speed: 0 }, { line: true, speed: 7 }]) {
      expect(load({ version: 1, rows: [{ ...good, way }] }), JSON.stringify(way)).toBeNull();
    }
    const tools = [{ p: [0, 0], q: [1, 0, 0, 0] }, { p: [0, 0, 0], q: [0, 0, 0, 0] }, null].map((tool) => ({ tool }));
    for (const wrong of [{ by: 'x' }, { joints: ['a', 0] }, { joints: null }, ...tools]) {
      const told = load({ version: 1, rows: [{ ...good, target: { ...good.target, ...wrong } }] });
      expect(told, JSON.stringify(wrong)).toEqual({ way, target: null });
    }
  });

  it('is there as long as the page is where a browser keeps nothing', () => {
    const refusing = { getItem: () => null, setItem: () => { throw new Error('full'); } };
    const aims = new Aims(refusing, () => 0);
    aims.put('left', model, { way, target: target('left') });
    expect(() => aims.flush()).not.toThrow();
    expect(aims.load('left', model)?.target).toEqual(target('left'));
  });
});
