import type { JSX } from 'preact';
import { t } from '../i18n';
import { clash, handOver, here, leftHere, trouble } from '../shelf_state';
import { openTheirs, saveMine } from '../teach';

/** What the controller did not keep, and what lies in this browser only. */
export function KeptNotes(): JSX.Element {
  const { programs, points } = here.value;
  const names = [...Object.keys(programs), ...points.map((one) => one.name)];
  const now = clash.value;
  return (
    <>
      {now && (
        <div class="callout grave" role="alert">
          <p>{t(now.revision === 0 ? 'kept.clash.gone' : 'kept.clash', { name: now.name })}</p>
          <div class="row">
            {now.revision !== 0 && (
              <button type="button" onClick={() => void openTheirs()}>
                {t('kept.theirs')}
              </button>
            )}
            <button type="button" class="primary" onClick={() => void saveMine()}>
              {t(now.revision === 0 ? 'kept.anew' : 'kept.mine')}
            </button>
          </div>
        </div>
      )}
      {trouble.value && (
        <p class="callout grave" role="alert">
          {trouble.value}
        </p>
      )}
      {names.length > 0 && !now && !leftHere.value && (
        <div class="callout" role="status">
          <p>{t('kept.here', { names: names.join(', ') })}</p>
          <div class="row">
            <button type="button" class="primary" onClick={() => void handOver()}>
              {t('kept.hand_over')}
            </button>
            <button type="button" onClick={() => (leftHere.value = true)}>
              {t('kept.leave')}
            </button>
          </div>
        </div>
      )}
    </>
  );
}
