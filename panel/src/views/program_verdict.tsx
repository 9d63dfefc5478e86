import type { JSX } from 'preact';
import { t, tWord } from '../i18n';
import { duration } from '../logic/units';
import type { ProgramVerdict } from '../logic/verdicts';
import { Icon } from './parts';

/** What the server says to rows, in its own words. */
export function ProgramVerdictCard({ verdict }: { verdict: ProgramVerdict }): JSX.Element {
  switch (verdict.kind) {
    case 'none':
      return <p class="verdict ask">{t('prog.empty')}</p>;
    case 'checking':
      return <p class="verdict checking">{t('move.checking')} …</p>;
    case 'lost':
      return <p class="verdict checking">{t('connection.lost')}</p>;
    case 'fine': {
      const { first_move, duration_s, homing_at_most_s, limited } = verdict.preview;
      return (
        <div class="verdict fine" role="status">
          <p class="verdict-head">
            <Icon name={first_move ? 'fault' : 'check'} />
            {t(first_move ? 'move.unchecked' : 'prog.fine')}
            <strong>{duration(duration_s)}</strong>
          </p>
          {homing_at_most_s > 0 && <p>{t('prog.homing', { time: duration(homing_at_most_s) })}</p>}
          {first_move ? (
            <p>{t('move.first')}</p>
          ) : (
            limited && <p>{tWord('move.limited', limited.by, { joint: limited.joint ?? '' })}</p>
          )}
        </div>
      );
    }
    case 'unsure':
      return (
        <div class="verdict" role="status">
          <p class="verdict-head">
            <Icon name="fault" /> {t('prog.unsure', { lines: verdict.lines.join(', ') })}
          </p>
          <p>{t('prog.unsure.why')}</p>
        </div>
      );
    case 'refused':
      return (
        <div class="verdict refused" role="status">
          <p class="verdict-head">
            <Icon name="fault" /> {t('move.refused')}
            {verdict.line !== null && <span>{t('prog.in_row', { line: verdict.line })}</span>}
          </p>
          <p>{verdict.sentence}</p>
        </div>
      );
  }
}
