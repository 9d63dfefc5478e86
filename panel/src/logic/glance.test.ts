import { describe, expect, it } from 'vitest';
import { en } from '../i18n/en';
import { whatLimits } from './glance';
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

describe('whatLimits', () => {
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
