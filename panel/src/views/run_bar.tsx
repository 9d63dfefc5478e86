import type { JSX } from 'preact';
import { errorSentence, t, tWord } from '../i18n';
import { atWork, canMove, robot, setPace, status, store } from '../app';
import { secondsLeft } from '../logic/glance';
import { decimals, duration } from '../logic/units';
import {
  brokenOffLine,
  check,
  failedLine,
  job,
  outdated,
  pause,
  programTitle,
  resume,
  run,
  running,
  scrub,
  step,
  stopJob,
  text,
  verdict,
} from '../teach';
import { Icon, Slider } from './parts';
import { ProgramVerdictCard } from './program_verdict';

/** What the server says to the program, and what can be done with it now. */
export function RunBar(): JSX.Element {
  const now = running.value;
  const paused = now?.phase === 'paused' || status.value?.state === 'held';
  const fits = verdict.value.kind === 'fine';
  const starts = fits && canMove.value && !atWork.value && text.value.trim() !== '';
  const mine = store.lease(robot.value ?? '') === 'mine';
  const feed = status.value?.feed ?? 1;
  return (
    <div class="pane-foot run-bar">
      {now ? <Progress /> : <ProgramVerdictCard verdict={verdict.value} />}
      {!now && job.value?.over && job.value.phase !== 'done' && (
        <p class={`last-end${job.value.phase === 'failed' ? ' grave' : ''}`} role="status">
          {tWord('events.job', job.value.phase, {
            title: job.value.title,
            text: job.value.error ? errorSentence(job.value.error) : '',
            time: '',
          })}
          {failedLine.value !== null && ` (${t('prog.in_row', { line: failedLine.value })})`}
          {brokenOffLine.value !== null && (
            <button type="button" class="quiet" disabled={!starts} onClick={() => void run({ fromLine: brokenOffLine.value! })}>
              {t('prog.go_on_from', { line: brokenOffLine.value })}
            </button>
          )}
        </p>
      )}
      {now && outdated.value && <p class="hint">{t('prog.older_runs')}</p>}
      <div class="run-keys">
        {now && paused ? (
          <button type="button" class="primary big" data-tour="resume" onClick={resume}>
            <Icon name="play" /> {t(store.guarded(now.robot) ? 'robot.resume.guarded' : 'robot.resume')}
          </button>
        ) : now ? (
          <button type="button" class="primary big" data-tour="pause" onClick={pause}>
            <Icon name="pause" /> {t('prog.pause')}
          </button>
        ) : (
          <button
            type="button"
            class="primary big"
            data-tour="run"
            disabled={!starts}
            onClick={() => void run()}
          >
            <Icon name="play" /> {t('prog.run')}
          </button>
        )}
        <button type="button" disabled={now?.phase !== 'paused'} title={`${t('prog.step_back')}: ${t('prog.step_back.title')}`} onClick={() => step(true)}>
          <Icon name="back" size={16} /> <span>{t('prog.step_back')}</span>
        </button>
        <button
          type="button"
          data-tour="step"
          disabled={now ? false : !starts}
          title={`${t('prog.step')}: ${t('prog.step.title')}`}
          onClick={() => step()}
        >
          <Icon name="step" size={16} /> <span>{t('prog.step')}</span>
        </button>
        <button type="button" disabled={!atWork.value} title={`${t('prog.stop')}: ${t('prog.stop.title')}`} onClick={stopJob}>
          <Icon name="stop" size={16} /> <span>{t('prog.stop')}</span>
        </button>
        {!now && (
          <button type="button" title={t('prog.check')} onClick={check} disabled={text.value.trim() === ''}>
            <Icon name="check" size={16} /> <span>{t('prog.check')}</span>
          </button>
        )}
      </div>
      <div class="run-sliders">
        {!now && <Scrub />}
        {mine && (
          <Slider
            label={t('jog.pace')}
            value={Math.min(1, feed)}
            min={0.05}
            max={1}
            step={0.05}
            text={`${Math.round(100 * feed)} %`}
            onInput={(share) => setPace(robot.value!, share)}
          />
        )}
      </div>
    </div>
  );
}

function Progress(): JSX.Element {
  const now = running.value!;
  const percent = Math.round(100 * now.progress);
  return (
    <div class="progress">
      <p class="verdict-head">
        {now.title !== programTitle() && <span>{now.title}</span>}
        {tWord('prog.phase', now.phase)}
        {now.line > 0 && <span>{t('prog.in_row', { line: now.line })}</span>}
        {now.client_lost && <span>{t('prog.client_lost')}</span>}
        {now.waits_for && <span>{t('limit.waits', { robot: now.waits_for })}</span>}
        <strong>{duration(secondsLeft(now, store.timeScale(now.robot)))}</strong>
      </p>
      {now.phase === 'paused' && now.paused_by && (
        <p class="hint" role="status">{errorSentence(now.paused_by)}</p>
      )}
      <span class="bar" role="progressbar" aria-valuenow={percent} aria-valuemin={0} aria-valuemax={100}>
        <span style={{ width: `${percent}%` }} />
      </span>
    </div>
  );
}

/** Where the ghost would be at a time of the program. */
function Scrub(): JSX.Element | null {
  const judged = verdict.value;
  if (judged.kind !== 'fine' || !judged.preview) return null;
  const times = judged.preview.samples.t_s;
  const last = times.at(-1) ?? 0;
  if (last <= 0) return null;
  const at = scrub.value ?? last;
  return (
    <Slider
      label={t('prog.scrub')}
      value={at}
      min={times[0] ?? 0}
      max={last}
      step={last / 500}
      text={`${decimals(at, 1)} s`}
      onInput={(value) => (scrub.value = value)}
    />
  );
}
