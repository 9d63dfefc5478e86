import type { JSX } from 'preact';
import { t } from '../i18n';
import { robot, status, store } from '../app';

/** The one step that is missing before anything can move, where one is. */
export function ReadyFirst(): JSX.Element | null {
  const name = robot.value;
  const now = status.value;
  if (!name || !now) return null;
  const other = store.lease(name) === 'other';
  if (now.state === 'fault' && now.fault) {
    return (
      <div class="callout grave" role="alert">
        <p>{now.fault.error.sentence}</p>
        <button type="button" class="primary" onClick={() => void store.acknowledge(name)}>
          {t('events.acknowledge')}
        </button>
      </div>
    );
  }
  if (other) {
    return (
      <div class="callout">
        <p>{t('robot.other', { robot: name })}</p>
        <button type="button" title={t('lease.take_over.title')} onClick={() => void store.control(name, true)}>
          {t('lease.take_over')}
        </button>
      </div>
    );
  }
  if (now.state !== 'off') return null;
  return (
    <div class="callout" data-tour="enable">
      <p>{t('robot.ready_first', { robot: name })}</p>
      <button type="button" class="primary" onClick={() => void store.enable(name)}>
        {t('robot.enable')}
      </button>
    </div>
  );
}
