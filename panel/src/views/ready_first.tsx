import type { JSX } from 'preact';
import { errorSentence, t } from '../i18n';
import { go, robot, status, store } from '../app';
import { RemedyText } from './remedy';

/** Nobody is sure where it stands: why, and the way out. */
function Unsure({ name }: { name: string }): JSX.Element | null {
  const found = store.robots.value.find((one) => one.name === name)?.position_journal;
  return (
    <div class="callout">
      <p>
        <strong>{t('quality.uncertain')}.</strong> {t('limit.uncertain')}.
      </p>
      {found && <p>{t('recover.found', { text: found.found })}</p>}
      {found && <p>{t('recover.way_out', { text: found.way_out })}</p>}
      <button type="button" onClick={() => go({ view: 'setup' })}>
        {t('recover.open')}
      </button>
    </div>
  );
}

/** The one step that is missing before anything can move, where one is. */
export function ReadyFirst(): JSX.Element | null {
  const name = robot.value;
  const now = status.value;
  if (!name || !now || store.role.value === 'viewer') return null;
  const other = store.lease(name) === 'other';
  if (now.state === 'fault' && now.fault) {
    return (
      <div class="callout grave" role="alert">
        <p>{errorSentence(now.fault.error)}</p>
        <RemedyText code={now.fault.error.code} cause={now.fault.cause} />
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
  if (now.position === 'uncertain') return <Unsure name={name} />;
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
