import type { JSX } from 'preact';
import { t } from '../i18n';

/** The rest of a list: how much there is, and a page of it more. @param forward  it goes on in time, not back */
export function Older({ more, forward, onClick }: { more: number; forward?: boolean; onClick: () => void }): JSX.Element | null {
  if (more <= 0) return null;
  return (
    <button type="button" class="quiet older" onClick={onClick}>
      {t(forward ? 'list.rest' : 'list.older', { count: more })}
    </button>
  );
}
