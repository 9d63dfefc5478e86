import { describe, expect, it } from 'vitest';
import { PadHold, padMode, padShares, padStep, stick } from './gamepad';
import type { JogAxis } from './jog_axes';

const axes = (...names: string[]): JogAxis[] => names.map((name) => ({ name, measure: 'angle', speed: 1 }));
const pose = axes('x', 'y', 'z', 'rx', 'ry', 'rz');
const five = axes('x', 'y', 'z', 'pitch', 'roll');
const pad = (sticks: number[], ...held: number[]) => ({
  axes: sticks,
  buttons: Array.from({ length: 17 }, (_, i) => ({ pressed: held.includes(i) })),
});

describe('gamepad', () => {
  it('does nothing without its dead man, with both of them, or in the middle', () => {
    expect(padShares(pad([1, 0, 0, 0]), pose, 'base', 0)).toBeNull();
    expect(padShares(pad([1, 0, 0, 0], 4, 5), pose, 'base', 0)).toBeNull();
    expect(padShares(pad([0.1, -0.1, 0, 0.15], 4), pose, 'base', 0)).toBeNull();
    expect(padShares({ axes: [], buttons: [] }, pose, 'base', 0)).toBeNull();
    expect(padMode(pad([], 4))).toBe('move');
    expect(padMode(pad([], 5))).toBe('turn');
  });
  it('goes where the stick points', () => {
    expect(padShares(pad([1, -1, 0, 0], 4), pose, 'base', 0)).toEqual([1, 1, 0, 0, 0, 0]);
    expect(padShares(pad([0, 0, 1, -1], 4), pose, 'base', 0)).toEqual([0, 0, 1, 0, 0, 0]);
    expect(stick(0.58)).toBeGreaterThan(0);
    expect(stick(0.58)).toBeLessThan(0.5);
    expect(stick(NaN)).toBe(0);
  });
  it('turns what the tool can turn', () => {
    expect(padShares(pad([1, 0, -1, 0], 5), pose, 'tool', 0)).toEqual([0, 0, 0, 1, 0, 1]);
    expect(padShares(pad([0, 1, 0, 0], 5), pose, 'tool', 0)).toEqual([0, 0, 0, 0, -1, 0]);
    expect(padShares(pad([1, -1, -1, 0], 5), five, 'tool', 0)).toEqual([0, 0, 0, 1, 1]);
    expect(padShares(pad([1, 1, 1, 1], 5), axes('x', 'y', 'z'), 'base', 0)).toBeNull();
  });
  it('moves the chosen joint, which its cross chooses', () => {
    expect(padShares(pad([-1, 1, 1, 1], 4), five, 'joint', 2)).toEqual([0, 0, -1, 0, 0]);
    expect(padShares(pad([-1, 0, 0, 0], 5), five, 'joint', 4)).toEqual([0, 0, 0, 0, -1]);
    expect(padShares(pad([-1, 0, 0, 0], 4), five, 'joint', 5)).toBeNull();
    expect([pad([], 12), pad([], 13), pad([], 12, 13), pad([])].map(padStep)).toEqual([-1, 1, 0, 0]);
  });
});

describe('a pad that is looked at', () => {
  const moving = () => {
    const hold = new PadHold();
    expect(hold.look(false, false, 'arm base')).toBe('rest');
    expect(hold.look(true, false, 'arm base')).toBe('begin');
    expect(hold.look(true, true, 'arm base')).toBe('go_on');
    return hold;
  };
  it('asks once, and goes on while it is held', () => {
    const hold = new PadHold();
    hold.look(false, false, 'arm base');
    expect(hold.look(true, false, 'arm base')).toBe('begin');
    expect(hold.look(true, false, 'arm base')).toBe('wait');
    expect(hold.asks('arm base')).toBe(true);
    expect(hold.look(false, false, 'arm base')).toBe('rest');
    expect(hold.asks('arm base')).toBe(false);
  });
  it('moves nothing that it was pressed before', () => {
    expect(new PadHold().look(true, false, 'arm base')).toBe('rest');
  });
  it('has to be let go when something else has ended it', () => {
    const hold = moving();
    expect(hold.look(true, false, 'arm base')).toBe('rest');
    expect(hold.look(true, false, 'arm base')).toBe('rest');
    hold.look(false, false, 'arm base');
    expect(hold.look(true, false, 'arm base')).toBe('begin');
  });
  it('.. or another robot or frame is meant, or it was gone', () => {
    expect(moving().look(true, true, 'max base')).toBe('rest');
    const hold = moving();
    hold.lose();
    expect(hold.look(true, true, 'arm base')).toBe('rest');
  });
});
