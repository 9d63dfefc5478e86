import { describe, expect, it } from 'vitest';
import { calledBy, expand, withPoints } from './expand';
import type { Point } from './points';
import fixture from './models.fixture.json';
import type { RobotModel } from './types';

const model = Object.values(fixture as unknown as Record<string, RobotModel>).find((one) => one.robot === 'learm')!;
const deg = Math.PI / 180;
const points: Point[] = [
  { name: 'ready', joints: [10 * deg, 20 * deg, 40 * deg, 40 * deg, 0] },
  { name: 'bin', place: { x: 0.24, y: 0.02, z: 0.2, turns: { pitch: 100 * deg } } },
];

describe('a program as one text', () => {
  it('has the numbers of its points', () => {
    const row = (body: string) => (withPoints(body, model, points) as { body: string }).body;
    expect(row('joint to=ready speed=50%')).toBe(
      'joint base=10deg shoulder=20deg elbow=40deg wrist=40deg roll=0deg speed=50%',
    );
    expect(row('joint to=ready d.base=5deg')).toMatch(/^joint base=15deg shoulder=20deg/);
    expect(row('move to=ready')).toMatch(/^joint base=10deg/);
    expect(row('line to=ready')).toMatch(/^line x=[\d.]+mm y=[\d.]+mm z=[\d.]+mm pitch=100deg roll=0deg$/);
    expect(row('arc via=bin x=1mm')).toBe('arc via=240mm,20mm,200mm x=1mm');
    expect(row('spline bin 1mm,2mm,3mm speed=50%')).toBe('spline 240mm,20mm,200mm 1mm,2mm,3mm speed=50%');
    expect(row('jaws 20mm')).toBe('jaws 20mm');
  });

  it('has differences added to the numbers of a point, along the axes that are meant', () => {
    const row = (body: string) => (withPoints(body, model, points) as { body: string }).body;
    expect(row('line to=bin dz=5mm dpitch=-10deg speed=60mm/s')).toBe('line x=240mm y=20mm z=205mm pitch=90deg speed=60mm/s');
    const at = (body: string) => [...row(body).matchAll(/[xyz]=(-?[\d.]+)mm/g)].map((one) => Number(one[1]));
    const here = at('line to=ready');
    const on = at('line to=ready frame=tool dz=20mm');
    // The tool points out along its base's turn, 10 deg down: pitch is 100 deg from straight up.
    expect(on[0]! - here[0]!).toBeCloseTo(20 * Math.sin(100 * deg) * Math.cos(10 * deg), 2);
    expect(on[1]! - here[1]!).toBeCloseTo(20 * Math.sin(100 * deg) * Math.sin(10 * deg), 2);
    expect(on[2]! - here[2]!).toBeCloseTo(20 * Math.cos(100 * deg), 2);
  });

  it('says which points are not there, and which places only a run can tell', () => {
    expect(withPoints('line to=nowhere', model, points)).toEqual({ unknown: 'nowhere' });
    expect(withPoints('line to=bin frame=tool dz=5mm', model, points)).toEqual({ open: true });
    const told = expand('wait 1s\nline to=bin frame=tool dz=5mm\ncall none\nline to=nowhere', model, points, {});
    expect(told.open).toEqual([2]);
    expect(told.missing).toEqual([
      { line: 3, what: 'program', name: 'none' },
      { line: 4, what: 'point', name: 'nowhere' },
    ]);
  });

  it('has what it calls in its place, and knows where each line comes from', () => {
    const programs = { grip: 'jaws 20mm\nwait settled', again: 'call again' };
    expect(expand('wait 1s\ncall grip\nwait 2s', model, [], programs)).toMatchObject({
      text: 'wait 1s\njaws 20mm\nwait settled\nwait 2s',
      lines: [1, 2, 2, 3],
    });
    expect(expand('call again', model, [], programs).text).toBe('call again');
    expect(expand('call constructor', model, [], programs).text).toBe('call constructor');
    expect(calledBy('call a\n', { a: 'call b', b: 'call a', c: '' })).toEqual({ a: 'call b', b: 'call a' });
  });
});
