import type { JSX } from 'preact';
import { useState } from 'preact/hooks';
import { t } from '../i18n';
import { atWork, canMove, robot, status, store } from '../app';
import { Icon } from './parts';
import { Sure } from './points_list';

/** An arm that can be guided by hand: its motors off, and holding again. */
export function FreeDrive(): JSX.Element | null {
  const name = robot.value;
  const now = status.value;
  const [sure, setSure] = useState(false);
  const can = store.robots.value.find((one) => one.name === name)?.free_drive;
  if (!name || !now || !can || store.role.value === 'viewer') return null;
  if (now.free_drive) {
    return (
      <div class="callout" role="status">
        <p>
          <strong>{t('free.on')}</strong> {t('free.on.text')}
        </p>
        <button type="button" class="primary" onClick={() => void store.freeDrive(name, false)}>
          {t('free.hold')}
        </button>
      </div>
    );
  }
  return (
    <>
      <button type="button" disabled={!canMove.value || atWork.value} title={t('free.title')} onClick={() => setSure(true)}>
        <Icon name="grab" /> {t('free.drive')}
      </button>
      {sure && (
        <Sure text={t('free.sure')} no={t('free.no')} onYes={() => void store.freeDrive(name, true)} onEnd={() => setSure(false)} />
      )}
    </>
  );
}
