import type { JSX } from 'preact';
import { useSignal } from '@preact/signals';
import { useEffect, useMemo, useState } from 'preact/hooks';
import { t } from '../i18n';
import { between } from '../logic/history';
import { fitted, hold, kSpans, shift, zoom } from '../logic/plot_window';
import { lengthOf } from '../logic/record';
import { csvOf, kQuantities, linesOf, ofJoints, thinned, type Line, type Quantity } from '../logic/series';
import { clamp, decimals } from '../logic/units';
import { handOver } from '../hand_over';
import {
  ends,
  frames,
  liveWindow,
  mode,
  newest,
  picks,
  playhead,
  playing,
  playSpeed,
  quantities,
  record,
  recordName,
  recordWindow,
  shownNow,
  windowNow,
  zeroTime,
} from '../plots_state';
import { Chart, Swatch } from './chart';
import { Icon, Segments, useFrames } from './parts';

const kSync = 'plots';
const names = () => ({ trip: t('plots.trip'), late: t('plots.late') });
/** In the order of the list, however they were chosen. */
const shownQuantities = (): Quantity[] => kQuantities.filter((one) => quantities.value.includes(one));

/** Times at which the picture of what comes in is made anew: a long one changes little. */
function useTicks(on: boolean, span: number): number {
  const [tick, setTick] = useState(0);
  useEffect(() => {
    if (!on) return;
    const timer = setInterval(() => setTick((n) => n + 1), span > 120 ? 1000 : span > 20 ? 400 : 150);
    return () => clearInterval(timer);
  }, [on, span > 120, span > 20]);
  return tick;
}

/** The charts under the 3D view, and what they show of time. */
export function PlotsDock(): JSX.Element {
  const held = windowNow().value.held;
  const live = mode.value === 'live';
  const tick = useTicks(live && !held, liveWindow.value.span);
  const shown = mode.value === 'record' && !record.value ? [] : shownQuantities();
  return (
    <section class={`dock plots-dock plots-${mode.value}`} aria-label={t('view.plots')}>
      <TimeBar />
      <div class="charts" tabIndex={0} role="group" aria-label={t('view.plots')} style={{ '--charts': Math.max(1, shown.length) } as JSX.CSSProperties}>
        {shown.length === 0 || picks.value.length === 0 ? (
          <p class="empty">{t(mode.value === 'record' && !record.value ? 'plots.none.record' : 'plots.none')}</p>
        ) : (
          shown.map((one) => <QuantityChart key={one} quantity={one} tick={tick} />)
        )}
      </div>
      {mode.value === 'record' && record.value && <Player />}
    </section>
  );
}

function TimeBar(): JSX.Element {
  const live = mode.value === 'live';
  const now = windowNow();
  const held = now.value.held !== null;
  const turn = (how: (n: number, o: number) => typeof now.value) => {
    const { oldest, newest: last } = ends();
    now.value = how(last, oldest);
  };
  const tool = (icon: 'plus' | 'minus' | 'back' | 'later', label: string, onClick: () => void) => (
    <button type="button" class="quiet" title={label} aria-label={label} onClick={onClick}>
      <Icon name={icon} size={16} />
    </button>
  );
  return (
    <div class="dock-head plots-head">
      {live && (
        <>
          <button
            type="button"
            class={held ? 'primary' : ''}
            aria-pressed={held}
            onClick={() => {
              if (held) liveWindow.value = { ...liveWindow.value, held: null };
              else turn((last) => hold(liveWindow.value, last));
            }}
          >
            <Icon name={held ? 'play' : 'pause'} size={15} /> {t(held ? 'plots.follow' : 'plots.pause')}
          </button>
          <Segments
            hideLabel
            label={t('plots.span')}
            value={held ? '' : String(liveWindow.value.span)}
            options={kSpans.map((span) => ({ value: String(span), text: t(`plots.span.${span}`) }))}
            onChange={(value) => (liveWindow.value = { span: Number(value), held: null })}
          />
        </>
      )}
      <div class="row plots-zoom" role="group" aria-label={t('plots.zoom')}>
        {tool('back', t('plots.earlier'), () => turn((n, o) => shift(now.value, n, o, -0.5)))}
        {tool('minus', t('plots.zoom.out'), () => turn((n, o) => zoom(now.value, n, o, 2)))}
        {tool('plus', t('plots.zoom.in'), () => turn((n, o) => zoom(now.value, n, o, 0.5)))}
        {tool('later', t('plots.later'), () => turn((n, o) => shift(now.value, n, o, 0.5)))}
        {!live && (
          <button type="button" class="quiet" onClick={() => turn((n, o) => ({ ...now.value, held: { low: o, high: n } }))}>
            {t('plots.whole')}
          </button>
        )}
      </div>
      <button type="button" class="plots-save" disabled={picks.value.length === 0} onClick={saveSeen}>
        <Icon name="save" size={16} /> {t('plots.save')}
      </button>
    </div>
  );
}

/** What is seen, every sample of it. */
function saveSeen(): void {
  const { low, high } = shownNow();
  const seen = frames().filter((one) => one.t >= low && one.t <= high);
  const charts = shownQuantities().map((quantity) => ({ quantity, lines: linesOf(seen, picks.value, quantity, names()) }));
  const base = mode.value === 'record' ? recordName.value.replace(/\.mcap$/i, '') : 'sinew';
  const stamp = new Date().toISOString().slice(0, 19).replaceAll(':', '-');
  handOver(`${base}_${stamp}.csv`, csvOf(seen.map((one) => one.t), charts), 'text/csv;charset=utf-8');
}

/** Seconds before now while it is live, else from the beginning of the record. */
const timeText = (at: number): string => {
  const whole = Number(at.toFixed(3));
  return mode.value === 'live' && whole === 0 ? t('plots.now') : `${String(whole).replace('-', '−')} s`;
};

const kPointsMax = 1400;

function QuantityChart({ quantity, tick }: { quantity: Quantity; tick: number }): JSX.Element {
  const cursor = useSignal<number | null>(null);
  const chosen = picks.value;
  const window = windowNow().value;
  const { low, high } = mode.value === 'live' && !window.held ? { low: newest.peek() - window.span, high: newest.peek() } : shownNow();
  const zero = zeroTime();
  const seen = useMemo(() => {
    const inside = between(frames(), low, high);
    const all = linesOf(inside, chosen, quantity, names());
    return thinned(inside.map((one) => one.t - zero), all, kPointsMax);
  }, [zero, tick, low, high, chosen, quantity, mode.value, record.value]);
  const zoomed = (from: number, to: number) => {
    const { oldest, newest: last } = ends();
    windowNow().value = { ...windowNow().value, held: fitted(from + zero, to + zero, oldest, last) };
  };
  const nothing = seen.lines.every((line) => line.values.every(Number.isNaN));
  return (
    <figure class="chart">
      <figcaption>
        <strong>{t(`plots.${quantity}`)}</strong>
        <ul class="legend">
          {seen.lines.map((line) => (
            <li key={line.label}>
              <Swatch hue={line.hue} /> {labelOf(line, quantity)} <output>{valueText(line, cursor.value)}</output>
            </li>
          ))}
        </ul>
      </figcaption>
      <div class="chart-box">
        <Chart
          t={seen.t}
          lines={seen.lines}
          low={low - zero}
          high={high - zero}
          sync={kSync}
          timeText={timeText}
          at={mode.value === 'record' ? playhead.value : null}
          onZoom={zoomed}
          onWhole={() => {
            const { oldest, newest: last } = ends();
            if (mode.value === 'live') liveWindow.value = { ...liveWindow.value, held: null };
            else recordWindow.value = { ...recordWindow.value, held: { low: oldest, high: last } };
          }}
          onPick={(at) => {
            if (mode.value === 'record' && record.value) playhead.value = clamp(at, 0, lengthOf(record.value));
          }}
          onCursor={(index) => (cursor.value = index)}
        />
        {nothing && <p class="chart-none">{t(quantity === 'error' ? 'plots.none.error' : 'plots.none.known')}</p>}
      </div>
    </figure>
  );
}

/** One robot's joints need no name in front of each. */
function labelOf(line: Line, quantity: Quantity): string {
  const robots = new Set(picks.value.map((one) => one.robot));
  return ofJoints(quantity) && robots.size === 1 ? line.label.slice(line.label.indexOf('.') + 1) : line.label;
}

function valueText(line: Line, at: number | null): string {
  let k = at ?? line.values.length - 1;
  while (at === null && k > 0 && Number.isNaN(line.values[k]!)) --k;
  const value = line.values[k];
  if (value === undefined || Number.isNaN(value)) return '–';
  const places = Math.abs(value) >= 1000 ? 1 : 2;
  return `${decimals(value, places)} ${line.unit}`.replace(' °', '°');
}

const kSpeeds = [0.25, 1, 4, 20, 200] as const;

/** The record's time: what the 3D view shows of it. */
function Player(): JSX.Element {
  const one = record.value!;
  const end = lengthOf(one);
  useFrames(playing.value, (seconds) => {
    const next = playhead.value + seconds * playSpeed.value;
    if (next >= end) playing.value = false;
    playhead.value = Math.min(end, next);
  });
  return (
    <div class="dock-time plots-player">
      <button
        type="button"
        class="primary"
        aria-label={t(playing.value ? 'plots.player.pause' : 'plots.player.play')}
        onClick={() => {
          if (!playing.value && playhead.value >= end) playhead.value = 0;
          playing.value = !playing.value;
        }}
      >
        <Icon name={playing.value ? 'pause' : 'play'} size={16} />
      </button>
      <input
        type="range"
        class="slider"
        aria-label={t('plots.player.time')}
        aria-valuetext={`${decimals(playhead.value, 2)} s`}
        min={0}
        max={end}
        step={end / 2000 || 0.001}
        value={playhead.value}
        style={{ '--share': `${(100 * playhead.value) / (end || 1)}%` } as JSX.CSSProperties}
        onInput={(event) => {
          playing.value = false;
          playhead.value = Number(event.currentTarget.value);
        }}
      />
      <output>
        {decimals(playhead.value, 2)} / {decimals(end, 2)} s
      </output>
      <Segments
        hideLabel
        label={t('plots.player.speed')}
        value={String(playSpeed.value)}
        options={kSpeeds.map((speed) => ({ value: String(speed), text: `${speed}×` }))}
        onChange={(value) => (playSpeed.value = Number(value))}
      />
    </div>
  );
}
