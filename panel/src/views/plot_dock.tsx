import type { JSX } from 'preact';
import { useSignal } from '@preact/signals';
import { useMemo, useRef } from 'preact/hooks';
import { t } from '../i18n';
import { model, robot, scrub, target, verdict } from '../app';
import type { Line } from '../logic/series';
import type { PreviewJson, RobotModel } from '../logic/types';
import { decimals, toDeg, toMm } from '../logic/units';
import { Chart, Swatch } from './chart';
import { Icon, Segments, useFrames } from './parts';

const kQuantities = ['position', 'velocity', 'acceleration', 'jerk'] as const;
type Quantity = (typeof kQuantities)[number];

function rowsOf(preview: PreviewJson, quantity: Quantity): number[][] {
  const { samples } = preview;
  const rows = {
    position: samples.position_rad ?? samples.position_m ?? samples.position_rad_m,
    velocity: samples.velocity_rad_s ?? samples.velocity_m_s ?? samples.velocity_rad_m_s,
    acceleration: samples.acceleration_rad_s2 ?? samples.acceleration_m_s2 ?? samples.acceleration_rad_m_s2,
    jerk: samples.jerk_rad_s3 ?? samples.jerk_m_s3 ?? samples.jerk_rad_m_s3,
  }[quantity];
  return rows ?? [];
}

const unitText = (quantity: Quantity, slides: boolean): string =>
  (slides ? 'mm' : '°') + { position: '', velocity: '/s', acceleration: '/s²', jerk: '/s³' }[quantity];

/** The profile of what is previewed: each joint over time, and the ghost at any moment of it. */
export function PlotDock(): JSX.Element | null {
  const quantity = useSignal<Quantity>('velocity');
  const playing = useSignal(false);
  const judged = verdict.value;
  const one = model.value;
  // What is looked at while the next one is made: it would flicker, and the view above it with it.
  const kept = useRef<PreviewJson | null>(null);
  if (judged.kind === 'fine') kept.current = judged.preview;
  const known = kept.current?.robot === robot.value ? kept.current : null;
  const preview = target.value && (judged.kind === 'fine' || judged.kind === 'checking') ? known : null;
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
    <section class="dock" aria-label={t('plot.title')} aria-busy={judged.kind === 'checking'}>
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
              <Swatch hue={i} /> {joint.name}
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
          {decimals(at, 2)} / {decimals(end, 2)} s
        </output>
      </div>
    </section>
  );
}

function Plot(props: { preview: PreviewJson; model: RobotModel; quantity: Quantity; at: number }): JSX.Element {
  const { preview, model: one, quantity, at } = props;
  const { t_s } = preview.samples;
  const lines = useMemo((): Line[] => {
    const rows = rowsOf(preview, quantity);
    return one.joints.map((joint, j) => {
      const slides = joint.kind === 'prismatic';
      const shown = slides ? toMm : toDeg;
      return {
        label: joint.name,
        unit: unitText(quantity, slides),
        hue: j,
        values: Float64Array.from(rows, (row) => shown(row[j] ?? 0)),
      };
    });
  }, [preview, quantity, one]);
  return <Chart t={t_s} lines={lines} low={t_s[0]!} high={t_s.at(-1)!} at={at} />;
}
