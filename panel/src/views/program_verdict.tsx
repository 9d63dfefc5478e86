import type { JSX } from 'preact';
import { refusalSentence, t, tWord } from '../i18n';
import { status } from '../app';
import { readRows } from '../logic/rows';
import { duration, timeSpan } from '../logic/units';
import type { ProgramVerdict, Why } from '../logic/verdicts';
import { Icon } from './parts';

/** Why a row is refused, and where, if that is in what it calls. */
export function whyText(why: Why): string {
  const { missing, key, file, line, round } = why;
  if (missing) return t(`prog.missing.${missing.what}`, { name: missing.name });
  const sentence = refusalSentence({ message: why.sentence, data: why.data });
  const said = key === undefined ? sentence : `${key}: ${sentence}`;
  const text = round === undefined ? said : t('prog.row.round', { round, text: said });
  if (file === undefined) return text;
  return line === undefined ? `${file}: ${text}` : t('prog.row.in', { file, line, text });
}

/** What the server says to rows, in its own words. */
export function ProgramVerdictCard({ verdict }: { verdict: ProgramVerdict }): JSX.Element {
  switch (verdict.kind) {
    case 'none':
      return <p class="verdict ask">{t('prog.empty')}</p>;
    case 'checking':
      return <p class="verdict checking">{t('move.checking')} …</p>;
    case 'lost':
      return <p class="verdict checking">{t('connection.lost')}</p>;
    case 'fine':
      return <Fine verdict={verdict} />;
    case 'refused':
      return (
        <div class="verdict refused" role="status">
          <p class="verdict-head">
            <Icon name="fault" /> {t('move.refused')}
            {verdict.line !== null && <span>{t('prog.in_row', { line: verdict.line })}</span>}
            {verdict.more > 0 && <span>{t('prog.more_refused', { count: verdict.more })}</span>}
          </p>
          <p>{whyText(verdict.why)}</p>
        </div>
      );
  }
}

function Fine({ verdict }: { verdict: ProgramVerdict & { kind: 'fine' } }): JSX.Element {
  const { judged, preview, hidden, unseen } = verdict;
  const first = judged ? readRows(judged.text).rows.find((row) => row.word !== '')?.word : undefined;
  // Where nobody knows where it stands its first move is slow, and nothing on the way is checked.
  const blind = preview ? preview.first_move : status.value?.position === 'lost' && first !== 'home';
  const homing = judged?.check.homing_at_most_s ?? preview?.homing_at_most_s ?? 0;
  const limited = preview?.limited;
  return (
    <div class="verdict fine" role="status">
      <p class="verdict-head">
        <Icon name={blind ? 'fault' : 'check'} />
        {t(blind ? 'move.unchecked' : 'prog.fine')}
        <strong>
          {judged
            ? timeSpan(judged.check.duration_min_s ?? 0, judged.check.duration_max_s ?? 0)
            : duration(preview?.duration_s ?? 0)}
        </strong>
      </p>
      {homing > 0 && <p>{t('prog.homing', { time: duration(homing) })}</p>}
      {blind ? (
        <p>{t('move.first')}</p>
      ) : (
        limited && <p>{tWord('move.limited', limited.by, { joint: limited.joint ?? '' })}</p>
      )}
      {hidden.length > 0 && (
        <p class="muted">
          {t('prog.hidden', { lines: hidden.join(', ') })} {t('prog.hidden.why')}
        </p>
      )}
      {unseen && <p class="muted">{t('prog.unseen', { text: whyText(unseen) })}</p>}
    </div>
  );
}
