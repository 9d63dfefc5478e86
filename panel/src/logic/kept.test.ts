import { describe, expect, it } from 'vitest';
import { changePoints, fetchKept, merged, onlyHere, pointOf, saveProgram, type Kept } from './kept';
import fixture from './models.fixture.json';
import type { Point } from './points';
import { ConnectionError, RpcError } from './rpc';
import type { RobotModel } from './types';

const model = Object.values(fixture as unknown as Record<string, RobotModel>).find((one) => one.robot === 'learm')!;

/** A controller that keeps texts, with the rule that its real one has. */
class Controller {
  readonly open = true;
  calls: string[] = [];
  programs = new Map<string, { text: string; revision: number }>();
  points: { name: string; position_rad: number[] }[] = [];
  revision = 0;
  fails: Error | null = null;

  call<Result>(method: string, params: object = {}): Promise<Result> {
    this.calls.push(method);
    if (this.fails) return Promise.reject(this.fails);
    const given = params as { name: string; text: string; revision: number; to: string; points: string };
    try {
      return Promise.resolve(this.answer(method, given) as Result);
    } catch (error) {
      return Promise.reject(error as Error);
    }
  }
  private answer(method: string, given: { name: string; text: string; revision: number; to: string; points: string }): unknown {
    const conflict = (now: number) => new RpcError(1, 'changed', { code: 'conflict', revision: now });
    if (method === 'programs.list') return { programs: [...this.programs].map(([name, { revision }]) => ({ name, revision })) };
    if (method === 'programs.load') return { name: given.name, ...this.programs.get(given.name)! };
    if (method === 'programs.save') {
      const now = this.programs.get(given.name)?.revision ?? 0;
      if (now !== given.revision) throw conflict(now);
      this.programs.set(given.name, { text: given.text, revision: now + 1 });
      return { revision: now + 1 };
    }
    if (method !== 'points.list') {
      if (given.revision !== this.revision) throw conflict(this.revision);
      ++this.revision;
      if (method === 'points.save') {
        for (const match of given.points.matchAll(/\[points\.(\S+)\]/g)) {
          this.points = [...this.points.filter((one) => one.name !== match[1]), { name: match[1]!, position_rad: [this.revision] }];
        }
      }
      if (method === 'points.remove') this.points = this.points.filter((one) => one.name !== given.name);
      if (method === 'points.rename') this.points = this.points.map((one) => (one.name === given.name ? { ...one, name: given.to } : one));
    }
    return { revision: this.revision, points: this.points };
  }
}

const point = (name: string): Point => ({ name, joints: [0, 0, 0, 0, 0] });
const none: Kept = { programs: {}, points: [], pointsRevision: 0 };

describe('what the controller keeps', () => {
  it('is asked for once, and then only where it has changed', async () => {
    const rpc = new Controller();
    rpc.programs.set('a', { text: 'wait 1s', revision: 7 }).set('b', { text: 'wait 2s', revision: 8 });
    const first = await fetchKept(rpc, 'left', null);
    expect(first.programs).toEqual({ a: { text: 'wait 1s', revision: 7 }, b: { text: 'wait 2s', revision: 8 } });
    rpc.programs.set('b', { text: 'wait 3s', revision: 9 }).delete('a');
    rpc.calls = [];
    const next = await fetchKept(rpc, 'left', first);
    expect(next.programs).toEqual({ b: { text: 'wait 3s', revision: 9 } });
    expect(rpc.calls).toEqual(['programs.list', 'points.list', 'programs.load']);
  });

  it('is replaced by who knows it, and by nobody else', async () => {
    const rpc = new Controller();
    expect(await saveProgram(rpc, 'left', 'a', 'one', 0)).toEqual({ text: 'one', revision: 1 });
    expect(await saveProgram(rpc, 'left', 'a', 'two', 0)).toEqual({ why: 'conflict', revision: 1 });
    expect(rpc.programs.get('a')!.text).toBe('one');
    rpc.fails = new RpcError(1, 'the disk is full', { code: 'disk' });
    expect(await saveProgram(rpc, 'left', 'a', 'two', 1)).toEqual({ why: 'refused', sentence: 'the disk is full' });
    rpc.fails = new ConnectionError('closed');
    expect(await saveProgram(rpc, 'left', 'a', 'two', 1)).toEqual({ why: 'lost' });
  });

  it('takes points of two browsers side by side, but not over each other', async () => {
    const rpc = new Controller();
    const change = (now: Pick<Kept, 'points' | 'pointsRevision'>, ...names: string[]) =>
      changePoints(rpc, 'left', model, ['angle'], { kind: 'save', points: names.map(point) }, now);
    const first = await change(none, 'a');
    expect(first).toEqual({ points: [{ name: 'a', joints: [1] }], pointsRevision: 1 });
    // Another browser that knows nothing of it: its own point gets there all the same.
    const second = await change(none, 'b');
    expect(second).toMatchObject({ pointsRevision: 2 });
    expect(rpc.points.map((one) => one.name)).toEqual(['a', 'b']);
    // The same point: not without having seen it.
    expect(await change(none, 'a')).toEqual({ why: 'conflict', revision: 2 });
    const known = second as Kept;
    expect(await changePoints(rpc, 'left', model, ['angle'], { kind: 'rename', name: 'a', to: 'c' }, known)).toMatchObject({ pointsRevision: 3 });
    expect(await changePoints(rpc, 'left', model, ['angle'], { kind: 'remove', name: 'a' }, known)).toMatchObject({ why: 'conflict' });
    expect(rpc.points.map((one) => one.name)).toEqual(['c', 'b']);
  });

  it('says where a point is, in joints or in space', () => {
    const turned = pointOf({ name: 'p', tool: { x_m: 0.1, y_m: 0, z_m: 0.2, quaternion_wxyz: [Math.SQRT1_2, 0, 0, Math.SQRT1_2] } });
    expect(turned.place!.turns['rz']).toBeCloseTo(Math.PI / 2);
    expect(pointOf({ name: 'p', tool: { x_m: 0, y_m: 0, z_m: 0, pitch_rad: 0.5, roll_rad: 0 } }).place!.turns).toEqual({ pitch: 0.5, roll: 0 });
    expect(pointOf({ name: 'p', position_m: [0.2], pose: { x_m: 1, y_m: 2, z_m: 3, quaternion_wxyz: [1, 0, 0, 0] }, source: 'x' })).toEqual({
      name: 'p', joints: [0.2], platform: { p: [1, 2, 3], q: [1, 0, 0, 0] }, source: 'x',
    });
  });
});

describe('what is shown', () => {
  const local = { programs: { a: 'mine', b: 'only here' }, points: [point('p'), point('q')], draft: { name: 'a', text: 'mine' } };
  const kept: Kept = { programs: { a: { text: 'theirs', revision: 1 } }, points: [{ name: 'p', joints: [1] }], pointsRevision: 1 };

  it('is the controller’s where both have something of a name, and nothing of this browser is lost', () => {
    expect(merged(local, null)).toBe(local);
    const both = merged(local, kept);
    expect(both.programs).toEqual({ a: 'theirs', b: 'only here' });
    expect(both.points.map((one) => [one.name, one.joints![0]])).toEqual([['p', 1], ['q', 0]]);
    expect(onlyHere(local, kept)).toEqual({ programs: { a: 'mine', b: 'only here' }, points: [point('q')] });
  });

  it('offers nothing before the controller has said what it has', () => {
    expect(onlyHere(local, null)).toEqual({ programs: {}, points: [] });
  });
});
