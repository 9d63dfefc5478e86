/** What holds a robot back now, the most important first: one line for people. */
import { errorSentence } from '../i18n';
import type { JobJson, RobotStatus } from './types';
import type { Lease } from './store';
import { duration } from './units';

export interface Limit {
  /** Key below `limit.` of the languages. */
  key: string;
  values: Record<string, string | number>;
  grave: boolean;
}

const limit = (key: string, values: Limit['values'] = {}, grave = false): Limit => ({ key, values, grave });

/**
 * Real seconds until a job has ended. What the server predicts is the robot's own time.
 * @param timeScale  how much faster that runs than ours
 */
export const secondsLeft = (job: Pick<JobJson, 'predicted_s' | 'progress'>, timeScale: number): number =>
  Math.max(0, job.predicted_s * (1 - job.progress)) / timeScale;

export function whatLimits(status: RobotStatus, lease: Lease, timeScale = 1): Limit {
  if (status.trouble) return limit('trouble', { text: status.trouble }, true);
  if (status.fault) return limit('fault', { text: errorSentence(status.fault.error) }, true);
  if (!status.connected) return limit('disconnected');
  if (status.state === 'off') return limit('off');
  if (status.homing) return limit('homing', { joint: status.homing });
  const job = status.job;
  if (job && !job.over) {
    if (job.waits_for) return limit('waits', { robot: job.waits_for });
    if (job.phase === 'paused') return limit('paused', { title: job.title });
    if (job.phase === 'running') {
      const percent = Math.round(100 * job.progress);
      const left = duration(secondsLeft(job, timeScale));
      return limit('program', { title: job.title, percent, left });
    }
  }
  const jog = status.jog;
  if (jog && !['none', 'no_command', 'stopped', 'expired'].includes(jog.reason)) {
    return limit(`jog.${jog.reason}`, { joint: jog.joint ?? '' });
  }
  if (status.position === 'lost') return limit('lost');
  if (status.position === 'uncertain') return limit('uncertain');
  if (lease === 'other') return limit('other');
  if (status.feed !== 1) return limit('feed', { percent: Math.round(100 * status.feed) });
  return limit('none');
}
