import { describe, expect, it } from 'vitest';
import { language } from '../i18n';
import { en } from '../i18n/en';
import { secondsLeft, whatLimits } from './glance';
import { ready } from './status.fixture';
import type { JobJson, RobotStatus } from './types';

const job = (over: Partial<JobJson>): JobJson => ({
  robot: 'arm',
  job: 1,
  client: 1,
  title: 'wave',
  phase: 'running',
  over: false,
  line: 1,
  predicted_s: 10,
  elapsed_s: 4,
  progress: 0.4,
  ...over,
});

describe('the time that is left', () => {
  it('is real time, also where a robot’s own runs faster', () => {
    expect(secondsLeft({ predicted_s: 100, progress: 0.4 }, 1)).toBeCloseTo(60);
    expect(secondsLeft({ predicted_s: 100, progress: 0.4 }, 20)).toBeCloseTo(3);
    expect(secondsLeft({ predicted_s: 100, progress: 1.1 }, 20)).toBe(0);
    const running = { ...ready, state: 'moving' as const, job: job({ predicted_s: 2400, progress: 0.5 }) };
    expect(whatLimits(running, 'mine', 200).values['left']).toBe('6.00 s');
    expect(whatLimits(running, 'mine').values['left']).toBe('20 min 00 s');
  });
});

describe('whatLimits', () => {
  it('says a fault in the language at hand', () => {
    const fault = { cause: 'device', error: { code: 'overheated', sentence: 'elbow is too hot; let it cool down', joint: 'elbow' } };
    const text = () => whatLimits({ ...ready, state: 'fault', fault }, 'mine').values['text'];
    expect(text()).toBe(fault.error.sentence);
    language.value = 'de';
    expect(text()).toBe('elbow ist zu heiß; abkühlen lassen');
    language.value = 'en';
  });

  const cases: [string, Partial<RobotStatus>, 'mine' | 'other' | 'free'][] = [
    ['none', {}, 'mine'],
    ['trouble', { trouble: 'no such port', state: 'off' }, 'free'],
    ['fault', { state: 'fault', fault: { cause: 'device', error: { code: 'x', sentence: 's' } } }, 'mine'],
    ['disconnected', { connected: false }, 'free'],
    ['off', { state: 'off', position: 'lost' }, 'free'],
    ['homing', { state: 'recovering', homing: 'elbow', position: 'lost' }, 'mine'],
    ['program', { state: 'moving', job: job({}) }, 'mine'],
    ['waits', { job: job({ waits_for: 'max' }) }, 'mine'],
    ['paused', { job: job({ phase: 'paused' }) }, 'mine'],
    ['jog.joint_limit', { jog: { reason: 'joint_limit', share: 0, joint: 'base' } }, 'mine'],
    ['none', { jog: { reason: 'none', share: 1 } }, 'mine'],
    ['lost', { position: 'lost' }, 'mine'],
    ['uncertain', { position: 'uncertain' }, 'mine'],
    ['other', {}, 'other'],
    ['feed', { feed: 0.5 }, 'mine'],
  ];
  for (const [key, over, lease] of cases) {
    it(`${key} ${JSON.stringify(over).slice(0, 40)}`, () => {
      const limit = whatLimits({ ...ready, ...over }, lease);
      expect(limit.key).toBe(key);
      expect(Object.keys(en)).toContain(`limit.${key}`);
    });
  }
});
