import { describe, expect, it } from 'vitest';
import {
  checkAmount,
  checkNumber,
  checkPlace,
  rangeOf,
  shareDone,
  stepLook,
  stepName,
  timeLeft,
  wasCutOff,
  withReason,
  type ProcedureJson,
} from './procedure';

const procedure: ProcedureJson = {
  robot: 'six',
  number: 3,
  client: 1,
  kind: 'recover',
  title: 'Recovery',
  phase: 'asking',
  over: false,
  answers: 1,
  place: 1,
  steps: [
    { step: 'adjust.leg1', text: 'leg1', state: 'done' },
    { step: 'adjust.leg2', text: 'leg2', state: 'open' },
    { step: 'place', text: 'where', state: 'failed' },
    { step: 'more', text: 'more', state: 'skipped' },
  ],
};

describe('the list', () => {
  it('marks the step under way, and none once it is over', () => {
    expect(procedure.steps.map((_, i) => stepLook(procedure, i))).toEqual(['done', 'now', 'failed', 'skipped']);
    expect(stepLook({ ...procedure, over: true }, 1)).toBe('open');
    expect(stepLook(procedure, 9)).toBe('open');
  });
  it('counts what is behind it', () => {
    expect(shareDone(procedure)).toBe(0.25);
    expect(shareDone({ ...procedure, phase: 'done', place: 4 })).toBe(1);
    expect(shareDone({ ...procedure, steps: [] })).toBe(0);
  });
  it('knows a kind of step and its joint', () => {
    expect(stepName('direction.base')).toEqual({ key: 'direction', joint: 'base' });
    expect(stepName('place')).toEqual({ key: 'place', joint: '' });
  });
  it('tells an end that nobody wanted from one that somebody did', () => {
    const ended: ProcedureJson = { ...procedure, over: true, phase: 'cancelled' };
    expect(wasCutOff(ended, false)).toBe(true);
    expect(wasCutOff(ended, true)).toBe(false);
    expect(wasCutOff({ ...ended, phase: 'done' }, false)).toBe(false);
    expect(wasCutOff(procedure, false)).toBe(false);
    expect(wasCutOff({ ...ended, number: 0 }, false)).toBe(false);
  });
});

describe('time left', () => {
  it('of a search is what it may still take', () => {
    expect(timeLeft({ words: '', elapsed_s: 30, at_most_s: 120, share: 0.9 })).toEqual({
      seconds: 90,
      atMost: true,
      share: 0.25,
    });
    expect(timeLeft({ words: '', elapsed_s: 130, at_most_s: 120 })!.seconds).toBe(0);
  });
  it('of a motion follows its share, once there is enough of it', () => {
    const left = timeLeft({ words: '', elapsed_s: 2, share: 0.4 })!;
    expect(left.seconds).toBeCloseTo(3);
    expect(left.atMost).toBe(false);
    expect(timeLeft({ words: '', elapsed_s: 2, share: 0.4 }, 20)!.seconds).toBeCloseTo(0.15);
    expect(timeLeft({ words: '', elapsed_s: 30, at_most_s: 120 }, 20)!.seconds).toBeCloseTo(4.5);
    expect(timeLeft({ words: '', elapsed_s: 0.1, share: 0.003 })).toBeNull();
    expect(timeLeft({ words: '', elapsed_s: 4 })).toBeNull();
    expect(timeLeft(undefined)).toBeNull();
  });
});

describe('answers', () => {
  const asks = { kind: 'number' as const, words: '', choices: [], ready: true };
  it('are asked for in the measure that the bounds have', () => {
    expect(rangeOf({ ...asks, lower_m: 0, upper_m: 1 })!.measure).toBe('length');
    expect(rangeOf({ ...asks, lower_rad: 0, upper_rad: 1 })!.measure).toBe('angle');
    expect(rangeOf({ ...asks, lower: 1, upper: 253 })).toEqual({ measure: null, lower: 1, upper: 253 });
    expect(rangeOf(asks)).toBeNull();
  });
  it('go out with a unit, whatever unit was typed', () => {
    const length = { measure: 'length' as const, lower: 0.0002, upper: 0.02 };
    expect(checkNumber('2', length)).toEqual({ answer: '2mm' });
    expect(checkNumber('0,5 cm', length)).toEqual({ answer: '5mm' });
    expect(checkNumber('20mm', length)).toEqual({ answer: '20mm' });
    expect(checkNumber('20.1', length)).toEqual({ wrong: 'range', low: '0.2 mm', high: '20.0 mm' });
    expect(checkNumber('two', length)).toEqual({ wrong: 'number' });
    expect(checkNumber(' ', length)).toEqual({ wrong: 'empty' });
    const angle = { measure: 'angle' as const, lower: -0.27, upper: 0.27 };
    expect(checkNumber('-1.5', angle)).toEqual({ answer: '-1.5deg' });
    expect(checkNumber('0.1rad', angle)).toEqual({ answer: '5.72957795deg' });
  });
  it('are whole where a count is asked for', () => {
    const count = { measure: null, lower: 1, upper: 253 };
    expect(checkNumber('12', count)).toEqual({ answer: '12' });
    expect(checkNumber('1.5', count)).toEqual({ wrong: 'whole' });
    expect(checkNumber('254', count)).toEqual({ wrong: 'range', low: '1', high: '253' });
  });
  it('move a joint by a little only, and not by nothing', () => {
    expect(checkAmount('-0.3', 'length')).toEqual({ answer: '-0.3mm' });
    expect('wrong' in checkAmount('11mm', 'length')).toBe(true);
    expect('wrong' in checkAmount('0', 'angle')).toBe(true);
    expect('wrong' in checkAmount('-21', 'angle')).toBe(true);
  });
  it('say a place by a value a joint, and why where it was moved', () => {
    expect(checkPlace(['10', '-5.5deg'], ['angle', 'angle'], '')).toEqual({ answer: '10deg,-5.5deg' });
    expect(checkPlace(['10', ''], ['angle', 'angle'], '')).toEqual({ wrong: 'empty' });
    expect(checkPlace(['a'], ['length'], '')).toEqual({ wrong: 'number' });
    expect(withReason('home', ' lifted\nby hand ')).toBe('home moved: lifted by hand');
    expect(withReason('home', '  ')).toBe('home');
  });
});
