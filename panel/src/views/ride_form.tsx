import type { JSX } from 'preact';
import { useSignal } from '@preact/signals';
import { errorSentence, t, tWord } from '../i18n';
import { atWork, canMove, status } from '../app';
import { duration } from '../logic/units';
import { ride, stopJob } from '../teach';
import { Icon, Slider } from './parts';

/** Random moves, all within reach and limits: one seed, one ride. */
export function RideForm(): JSX.Element {
  const seed = useSignal(1);
  const seconds = useSignal(30);
  const amplitude = useSignal(0);
  const job = status.value?.job?.title === 'bullride' ? status.value.job : null;
  const rides = job !== null && !job.over;
  return (
    <form
      class="ride"
      onSubmit={(event) => {
        event.preventDefault();
        const wide = amplitude.value > 0 ? { amplitude: amplitude.value } : {};
        void ride({ seed: seed.value, duration_s: seconds.value, ...wide });
      }}
    >
      <p class="hint">{t('ride.what')}</p>
      <div class="two">
        <label class="text-field">
          <span class="field-label">{t('ride.seed')}</span>
          <input
            type="number"
            min={0}
            max={999999}
            step={1}
            value={seed.value}
            onInput={(event) => (seed.value = Math.max(0, Math.round(Number(event.currentTarget.value) || 0)))}
          />
        </label>
        <label class="text-field">
          <span class="field-label">{t('ride.time')}</span>
          <input
            type="number"
            min={1}
            max={3600}
            step={1}
            value={seconds.value}
            onInput={(event) => (seconds.value = Math.min(3600, Math.max(1, Number(event.currentTarget.value) || 1)))}
          />
        </label>
      </div>
      <Slider
        label={t('ride.amplitude')}
        value={amplitude.value}
        min={0}
        max={1}
        step={0.05}
        text={amplitude.value > 0 ? `${Math.round(100 * amplitude.value)} %` : t('ride.amplitude.own')}
        onInput={(value) => (amplitude.value = value)}
      />
      {job && (
        <div class="ride-job" role="status">
          <p>
            {tWord('events.job', job.phase, {
              title: t('prog.tab.ride'),
              time: duration(job.predicted_s),
              text: job.error ? errorSentence(job.error) : '',
            })}
          </p>
          <span class="bar">
            <span style={{ width: `${100 * job.progress}%` }} />
          </span>
        </div>
      )}
      <div class="row">
        <button type="submit" class="primary big" data-tour="ride" disabled={!canMove.value || atWork.value}>
          <Icon name="play" /> {t('ride.start')}
        </button>
        <button type="button" class="big" disabled={!rides} onClick={stopJob}>
          <Icon name="stop" /> {t('ride.stop')}
        </button>
      </div>
    </form>
  );
}
