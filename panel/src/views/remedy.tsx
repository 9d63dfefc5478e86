import type { JSX } from 'preact';
import { t } from '../i18n';
import { remedyOf } from '../logic/remedy';

/** Under what has happened: what it means, and what to do. */
export function RemedyText(props: { code?: string; cause?: string }): JSX.Element | null {
  const remedy = remedyOf(props);
  if (!remedy) return null;
  return (
    <dl class="remedy">
      <dt>{t('remedy.means')}</dt>
      <dd>{t(remedy.means)}</dd>
      <dt>{t('remedy.do')}</dt>
      <dd>{t(remedy.todo)}</dd>
    </dl>
  );
}
