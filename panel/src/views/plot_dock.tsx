import type { JSX } from 'preact';
import { useSignal } from '@preact/signals';
import { useEffect, useRef } from 'preact/hooks';
import uPlot from 'uplot';
import 'uplot/dist/uPlot.min.css';
import { t } from '../i18n';
import { model, scrub, target, theme, verdict } from '../app';
import type { PreviewJson, RobotModel } from '../logic/types';
import { toDeg, toMm } from '../logic/units';
import { Icon, Segments, useFrames } from './parts';

const kQuantities = ['position', 'velocity', 'acceleration', 'jerk'] as const;
type Quantity = (typeof kQuantities)[number];

/** A hue a joint, of equal weight in both themes; red belongs to Stop. */
const kHues = [178, 42, 262, 96, 312, 214];
const lineColor = (i: number, dark: boolean): string =>
  `hsl(${kHues[i % kHues.length]} ${dark ? '62% 62%' : '70% 36%'})`;

function rowsOf(preview: PreviewJson, quantity: Quantity, legs: boolean): number[][] {
  const { samples } = preview;
  const rows = {
    position: legs ? samples.position_m : samples.position_rad,
    velocity: legs ? samples.velocity_m_s : samples.velocity_rad_s,
    acceleration: legs ? samples.acceleration_m_s2 : samples.acceleration_rad_s2,
    jerk: legs ? samples.jerk_m_s3 : samples.jerk_rad_s3,
  }[quantity];
  return rows ?? [];
}

const unitText = (quantity: Quantity, legs: boolean): string =>
  (legs ? 'mm' : '°') + { position: '', velocity: '/s', acceleration: '/s²', jerk: '/s³' }[quantity];

/** The profile of what is previewed: each joint over time, and the ghost at any moment of it. */
export function PlotDock(): JSX.Element | null {
  const quantity = useSignal<Quantity>('velocity');
  const playing = useSignal(false);
  const judged = verdict.value;
  const one = model.value;
  const preview = target.value && judged.kind === 'fine' ? judged.preview : null;
  const end = preview?.samples.t_s.at(-1) ?? 0;
  useFrames(playing.value && preview !== null, (seconds) => {
    const next = (scrub.value ?? 0) + seconds * Math.max(1, end / 8);
    if (next >= end) {
      playing.value = false;
      scrub.value = null;
    } else {
      scrub.value = next;
    }
  });
  if (!preview || !one || preview.samples.t_s.length < 2) return null;
  const at = scrub.value ?? end;
  return (
    <section class="dock" aria-label={t('plot.title')}>
      <div class="dock-head">
        <Segments
          hideLabel
          label={t('plot.title')}
          value={quantity.value}
          options={kQuantities.map((value) => ({ value, text: t(`plot.${value}`) }))}
          onChange={(value) => (quantity.value = value)}
        />
        <ul class="legend">
          {one.joints.map((joint, i) => (
            <li key={joint.name}>
              <span style={{ background: lineColor(i, theme.value === 'dark') }} />
              {joint.name}
            </li>
          ))}
        </ul>
      </div>
      <Plot preview={preview} model={one} quantity={quantity.value} at={at} />
      <div class="dock-time">
        <button
          type="button"
          class="quiet"
          aria-label={t(playing.value ? 'plot.pause' : 'plot.play')}
          onClick={() => {
            if (!playing.value && scrub.value === null) scrub.value = 0;
            playing.value = !playing.value;
          }}
        >
          <Icon name={playing.value ? 'pause' : 'play'} />
        </button>
        <input
          type="range"
          class="slider"
          aria-label={t('plot.time')}
          min={0}
          max={end}
          step={end / 500}
          value={at}
          style={{ '--share': `${(100 * at) / end}%` } as JSX.CSSProperties}
          onInput={(event) => {
            playing.value = false;
            scrub.value = Number(event.currentTarget.value);
          }}
        />
        <output>
          {at.toFixed(2)} / {end.toFixed(2)} s
        </output>
      </div>
    </section>
  );
}

function Plot(props: { preview: PreviewJson; model: RobotModel; quantity: Quantity; at: number }): JSX.Element {
  const { preview, model: one, quantity, at } = props;
  const host = useRef<HTMLDivElement>(null);
  const plot = useRef<uPlot | null>(null);
  const now = useRef(at);
  now.current = at;
  const dark = theme.value === 'dark';
  const legs = one.kind === 'hexapod';

  useEffect(() => {
    const box = host.current!;
    const css = getComputedStyle(document.documentElement);
    const ink = css.getPropertyValue('--ink-2').trim();
    const line = css.getPropertyValue('--line').trim();
    const accent = css.getPropertyValue('--accent').trim();
    const font = '11px "Inter Variable", system-ui, sans-serif';
    const axis = { stroke: ink, font, grid: { stroke: line, width: 1 }, ticks: { show: false } };
    const chart = new uPlot(
      {
        width: box.clientWidth,
        height: box.clientHeight,
        legend: { show: false },
        cursor: { show: false },
        padding: [8, 10, 0, 0],
        scales: { x: { time: false } },
        axes: [
          { ...axis, size: 26, values: (_, ticks) => ticks.map((one) => `${one} s`) },
          { ...axis, size: 58, values: (_, ticks) => ticks.map((one) => `${one}${unitText(quantity, legs)}`) },
        ],
        series: [
          {},
          ...one.joints.map((joint, i) => ({
            label: joint.name,
            stroke: lineColor(i, dark),
            width: 1.75,
            points: { show: false },
          })),
        ],
        hooks: {
          draw: [
            (chart) => {
              const x = chart.valToPos(now.current, 'x', true);
              const { ctx, bbox } = chart;
              ctx.save();
              ctx.strokeStyle = accent;
              ctx.lineWidth = devicePixelRatio;
              ctx.beginPath();
              ctx.moveTo(x, bbox.top);
              ctx.lineTo(x, bbox.top + bbox.height);
              ctx.stroke();
              ctx.restore();
            },
          ],
        },
      },
      dataOf(preview, quantity, legs, one.joints.length),
      box,
    );
    plot.current = chart;
    const watch = new ResizeObserver(() =>
      chart.setSize({ width: box.clientWidth, height: box.clientHeight }),
    );
    watch.observe(box);
    return () => {
      watch.disconnect();
      chart.destroy();
      plot.current = null;
    };
  }, [one, quantity, dark]);

  useEffect(() => {
    plot.current?.setData(dataOf(preview, quantity, legs, one.joints.length));
  }, [preview]);
  useEffect(() => {
    plot.current?.redraw(false);
  }, [at]);
  return <div class="plot" ref={host} aria-hidden="true" />;
}

function dataOf(preview: PreviewJson, quantity: Quantity, legs: boolean, joints: number): uPlot.AlignedData {
  const rows = rowsOf(preview, quantity, legs);
  const shown = legs ? toMm : toDeg;
  return [
    preview.samples.t_s,
    ...Array.from({ length: joints }, (_, j) => rows.map((row) => shown(row[j] ?? 0))),
  ];
}
