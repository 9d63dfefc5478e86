import type { JSX } from 'preact';
import { signal, useSignalEffect } from '@preact/signals';
import { useEffect, useRef, useState } from 'preact/hooks';
import { t } from '../i18n';
import { store } from '../app';
import { isFirstRun, kTour, nextStep, rememberTour } from '../logic/tour';

/** The step that is shown; nothing: no tour. */
const step = signal<number | null>(null);
const called = signal(false);

/** From the help page: then it takes the focus. */
export function showTour(): void {
  called.value = true;
  step.value = 0;
}
function end(): void {
  rememberTour(localStorage);
  step.value = null;
}

/**
 * Five things worth knowing, one after the other. It lies over the 3D view only, covers no control, and
 * waits for nobody: whoever goes on working without it may.
 */
export function Tour(): JSX.Element | null {
  const begun = useRef(false);
  const card = useRef<HTMLDivElement>(null);
  useSignalEffect(() => {
    if (begun.current || store.connection.value !== 'open') return;
    begun.current = true;
    if (isFirstRun(localStorage)) step.value = 0;
  });
  const now = step.value;
  useEffect(() => {
    if (now !== null && called.value) card.current?.focus();
  }, [now]);
  if (now === null || store.connection.value !== 'open') return null;
  const { id } = kTour[now]!;
  const last = now === kTour.length - 1;
  const go = (way: 1 | -1) => {
    const next = nextStep(now, way);
    if (next === null) end();
    else step.value = next;
  };
  return (
    <>
      <Ring step={now} />
      <div class="tour" role="dialog" aria-labelledby="tour-title" aria-describedby="tour-text" tabIndex={-1} ref={card}>
        <p class="tour-at">
          {t('tour.title')}
          <span>{t('tour.at', { step: now + 1, of: kTour.length })}</span>
        </p>
        <h3 id="tour-title">{t(`tour.${id}.title`)}</h3>
        <p id="tour-text">{t(`tour.${id}.text`)}</p>
        <div class="tour-dots" aria-hidden="true">
          {kTour.map((one, i) => (
            <i key={one.id} data-on={i === now} />
          ))}
        </div>
        <div class="row">
          {!last && (
            <button type="button" class="quiet" data-tour="skip" onClick={end}>
              {t('tour.skip')}
            </button>
          )}
          <span class="stretch" />
          {now > 0 && (
            <button type="button" onClick={() => go(-1)}>
              {t('tour.back')}
            </button>
          )}
          <button type="button" class="primary" onClick={() => go(1)}>
            {t(last ? 'tour.end' : 'tour.next')}
          </button>
        </div>
      </div>
    </>
  );
}

/** Around what is spoken of; it takes no pointer. */
function Ring({ step: now }: { step: number }): JSX.Element | null {
  const [box, setBox] = useState<DOMRect | null>(null);
  useEffect(() => {
    const look = () => {
      const found = kTour[now]!.at.map((one) => document.querySelector(one)).find((one) => one !== null);
      const next = found?.getBoundingClientRect() ?? null;
      setBox((old) => (old && next && old.x === next.x && old.y === next.y && old.width === next.width && old.height === next.height ? old : next));
    };
    look();
    const timer = setInterval(look, 300);
    return () => clearInterval(timer);
  }, [now]);
  if (!box) return null;
  const style = { left: `${box.x - 4}px`, top: `${box.y - 4}px`, width: `${box.width + 8}px`, height: `${box.height + 8}px` };
  return <div class="tour-ring" style={style} aria-hidden="true" />;
}
