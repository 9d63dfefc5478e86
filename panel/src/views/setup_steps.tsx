import type { JSX } from 'preact';
import { useEffect, useRef } from 'preact/hooks';
import { useSignal } from '@preact/signals';
import { t, tWord } from '../i18n';
import { stepLook, type ProcedureJson, type StepLook } from '../logic/procedure';
import { decimals } from '../logic/units';
import { Icon } from './parts';
import { stepTitle } from './setup_question';

const kMark: Record<StepLook, JSX.Element | null> = {
  open: null,
  now: null,
  done: <Icon name="check" size={13} />,
  skipped: <Icon name="skip" size={11} />,
  failed: <Icon name="close" size={13} />,
};

/** All steps in their order; where it is now, what was said and what was seen. */
export function StepList({ procedure }: { procedure: ProcedureJson }): JSX.Element {
  const list = useRef<HTMLOListElement>(null);
  useEffect(() => {
    const now = list.current?.querySelector<HTMLElement>('[aria-current]');
    // Only the list itself scrolls, never the question out of sight.
    if (now && list.current) list.current.scrollTop = now.offsetTop - list.current.clientHeight / 2;
  }, [procedure.number, procedure.place]);
  return (
    <section class="setup-steps">
      <h3>{t('setup.steps')}</h3>
      <ol ref={list} tabIndex={0} aria-label={t('setup.steps')}>
        {procedure.steps.map((step, i) => {
          const look = stepLook(procedure, i);
          const said = [step.answer && tWord('setup.word', step.answer), step.words].filter(Boolean);
          return (
            <li key={step.step} class={`setup-step look-${look}`} aria-current={look === 'now' ? 'step' : undefined}>
              <span class="step-mark">{kMark[look] ?? i + 1}</span>
              <span class="step-title" title={step.text}>
                {stepTitle(step.step)}
                <span class="sr-only">, {t(`setup.look.${look}`)}</span>
              </span>
              {said.length > 0 && <span class="step-said">{said.join(' · ')}</span>}
            </li>
          );
        })}
      </ol>
    </section>
  );
}

/** What the last one came to: what was found, where it was kept, and what did not go. */
export function ResultCard({ procedure }: { procedure: ProcedureJson }): JSX.Element | null {
  const open = useSignal(false);
  if (procedure.number === 0) return null;
  const good = procedure.phase === 'done';
  const said = procedure.steps.filter((step) => step.words && step.state !== 'skipped');
  return (
    <section class={`setup-result result-${procedure.phase}`} aria-label={t('setup.result')}>
      <h3>
        <Icon name={good ? 'check' : procedure.phase === 'failed' ? 'fault' : 'close'} size={16} />
        {t(`setup.result.${good ? 'done' : procedure.phase === 'failed' ? 'failed' : 'cancelled'}`, {
          title: tWord('procedure', procedure.kind),
        })}
      </h3>
      {procedure.trouble && <p class="question-trouble">{procedure.trouble}</p>}
      {procedure.note && <p class="question-trouble">{procedure.note}</p>}
      <Found procedure={procedure} />
      {said.length > 0 && (
        <>
          <button type="button" class="quiet" aria-expanded={open.value} onClick={() => (open.value = !open.value)}>
            {t(open.value ? 'setup.seen.hide' : 'setup.seen', { count: said.length })}
          </button>
          {open.value && (
            <dl class="facts">
              {said.map((step) => (
                <div key={step.step}>
                  <dt>{stepTitle(step.step)}</dt>
                  <dd class={step.state === 'failed' ? 'grave' : ''}>{step.words}</dd>
                </div>
              ))}
            </dl>
          )}
        </>
      )}
    </section>
  );
}

/** Settings that commissioning found to be other than in the robot's file, and the file that has them. */
export function Found({ procedure }: { procedure: ProcedureJson }): JSX.Element | null {
  if (!procedure.file) return null;
  const settings = Object.entries(procedure.settings ?? {});
  if (procedure.phase !== 'done') {
    return (
      <p class="hint">
        {t('setup.found.open')} <code>{procedure.file}</code>
      </p>
    );
  }
  return (
    <div class="found">
      {settings.length === 0 ? (
        <p>{t('setup.found.none')}</p>
      ) : (
        <>
          <p>{t('setup.found', { count: settings.length })}</p>
          <dl class="facts">
            {settings.map(([key, value]) => (
              <div key={key}>
                <dt>{settingTitle(key)}</dt>
                <dd>
                  <span class="tag">{settingText(key, value)}</span>
                </dd>
              </div>
            ))}
          </dl>
        </>
      )}
      <p class="hint">
        {t('setup.found.file')} <code>{procedure.file}</code>
      </p>
      {settings.length > 0 && (
        <p class="hint">
          {t('setup.found.use')} <code>{`settings = "${procedure.file}"`}</code>
        </p>
      )}
    </div>
  );
}

function settingTitle(key: string): string {
  const match = /^joint\.(.+)\.(turn|servo_id|trim_rad)$/.exec(key);
  return match ? tWord('setup.setting', match[2]!, { joint: match[1]! }) : tWord('setup.setting', key);
}
function settingText(key: string, value: string): string {
  if (key.endsWith('.trim_rad')) return `${decimals((Number(value) * 180) / Math.PI, 2)}°`;
  return key.endsWith('turn') && value === 'other' ? t('setup.setting.other') : value;
}
