import type { JSX } from 'preact';
import { useEffect, useRef, useState } from 'preact/hooks';
import uPlot from 'uplot';
import 'uplot/dist/uPlot.min.css';
import { theme } from '../app';
import type { Line } from '../logic/series';import { decimals } from '../logic/units';


/** A hue a joint, of equal weight in both themes; red belongs to Stop. */
const kHues = [178, 42, 262, 96, 312, 214];
export const lineColor = (i: number, dark: boolean): string =>
  `hsl(${kHues[i % kHues.length]} ${dark ? '62% 62%' : '70% 36%'})`;
/** The second robot's lines are dashed, the third one's dotted. */
const kDashes: number[][] = [[], [7, 4], [2, 3]];
const dashOf = (hue: number): number[] => kDashes[Math.floor(hue / kHues.length) % kDashes.length]!;

export function Swatch({ hue }: { hue: number }): JSX.Element {
  const dash = dashOf(hue).join(' ');
  return (
    <svg class="swatch" width="16" height="4" aria-hidden="true">
      <path d="M0 2h16" stroke={lineColor(hue, theme.value === 'dark')} stroke-width="3" stroke-dasharray={dash} />
    </svg>
  );
}

export interface ChartProps {
  t: ArrayLike<number>;
  lines: readonly Line[];
  low: number;
  high: number;
  /** Time that is marked. */
  at?: number | null;
  /** Charts with one key show one cursor. */
  sync?: string;
  timeText?: (t: number) => string;
  /** A part was dragged; a double click asks for all of it. */
  onZoom?: (low: number, high: number) => void;
  onWhole?: () => void;
  onPick?: (t: number) => void;
  /** Index into t that the pointer is at. */
  onCursor?: (index: number | null) => void;
}

const known = (values: Float64Array): (number | null)[] => Array.from(values, (one) => (Number.isNaN(one) ? null : one));
const dataOf = (props: ChartProps): uPlot.AlignedData => [
  Array.from(props.t),
  ...props.lines.map((line) => known(line.values)),
];
/** As many places as the steps between ticks need. */
const digits = (ticks: number[]): number => {
  const step = Math.abs((ticks[1] ?? 1) - (ticks[0] ?? 0)) || 1;
  for (let places = 0; places < 6; ++places) {
    if (Math.abs(Math.round(step * 10 ** places) - step * 10 ** places) < 1e-3) return places;
  }
  return 6;
};

/** Room above and below; a picture of nothing has its axis, too. */
const rangeOf = (_: uPlot, low: number | null, high: number | null): uPlot.Range.MinMax =>
  low === null || high === null ? [-1, 1] : uPlot.rangeNum(low, high, 0.1, true);

/**
 * A 2D canvas on the graphics processor waits for it: beside the 3D view, on a computer whose processor
 * plays one, charts of a moving robot stopped the page for 0.6 to 1.7 s at a time, longer than a lease
 * lasts; drawn by software they never stopped it for 0.3 s. uPlot leaves no choice, so it is made here.
 */
function bySoftware<Made>(make: () => Made): Made {
  const canvas = HTMLCanvasElement.prototype;
  const context = canvas.getContext;
  canvas.getContext = function (this: HTMLCanvasElement, kind: string, how?: object) {
    return context.call(this, kind, kind === '2d' ? { ...how, willReadFrequently: true } : how);
  } as typeof context;
  try {
    return make();
  } finally {
    canvas.getContext = context;
  }
}

/** Lines over time; each unit has an axis of its own, left and right. */
export function Chart(props: ChartProps): JSX.Element {
  const host = useRef<HTMLDivElement>(null);
  const plot = useRef<uPlot | null>(null);
  const latest = useRef(props);
  latest.current = props;
  const [, remade] = useState(0);
  const dark = theme.value === 'dark';
  const shape = props.lines.map((line) => `${line.label} ${line.unit} ${line.hue}`).join('|');

  useEffect(() => {
    const box = host.current!;
    const css = getComputedStyle(document.documentElement);
    const color = (name: string) => css.getPropertyValue(name).trim();
    const font = '11px "Inter Variable", system-ui, sans-serif';
    const grid = { stroke: color('--line'), width: 1 };
    const axis = { stroke: color('--ink-2'), font, grid, ticks: { show: false } };
    const units = [...new Set(latest.current.lines.map((line) => line.unit))].slice(0, 2);
    const drags = latest.current.onZoom !== undefined;
    const chart = bySoftware(() => new uPlot(
      {
        width: Math.max(50, box.clientWidth),
        height: Math.max(50, box.clientHeight),
        legend: { show: false },
        cursor: {
          show: drags,
          points: { size: 6 },
          drag: { x: drags, y: false, setScale: false },
          ...(latest.current.sync ? { sync: { key: latest.current.sync } } : {}),
        },
        padding: [8, 10, 0, 0],
        scales: {
          x: { time: false, range: () => [latest.current.low, latest.current.high] },
          ...Object.fromEntries(units.map((unit) => [unit, { range: rangeOf }])),
        },
        axes: [
          {
            ...axis,
            size: 26,
            values: (_, ticks) => ticks.map((one) => (latest.current.timeText ?? ((t: number) => `${t} s`))(one)),
          },
          ...units.map((unit, i) => ({
            ...axis,
            scale: unit,
            side: i === 0 ? (3 as const) : (1 as const),
            size: 74,
            grid: i === 0 ? grid : { show: false },
            values: (_: uPlot, ticks: number[]) => {
              const places = digits(ticks);
              return ticks.map((one) => `${decimals(one, places)} ${unit}`.replace(' °', '°'));
            },
          })),
        ],
        series: [
          {},
          ...latest.current.lines.map((line) => ({
            label: line.label,
            scale: units.includes(line.unit) ? line.unit : units[0],
            stroke: lineColor(line.hue, dark),
            dash: dashOf(line.hue),
            width: 1.75,
            points: { show: false },
          })),
        ],
        hooks: {
          draw: [(one) => mark(one, latest.current.at, color('--accent'))],
          setCursor: [(one) => latest.current.onCursor?.(one.cursor.idx ?? null)],
          setSelect: [
            (one) => {
              const { left, width } = one.select;
              if (width < 4) return;
              const [low, high] = [one.posToVal(left, 'x'), one.posToVal(left + width, 'x')];
              one.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
              latest.current.onZoom?.(low, high);
            },
          ],
        },
      },
      dataOf(latest.current),
      box,
    ));
    chart.over.addEventListener('click', () => {
      if (chart.cursor.left !== undefined && chart.cursor.left >= 0 && chart.select.width < 4) {
        latest.current.onPick?.(chart.posToVal(chart.cursor.left, 'x'));
      }
    });
    chart.over.addEventListener('dblclick', () => latest.current.onWhole?.());
    plot.current = chart;
    remade((n) => n + 1);
    const watch = new ResizeObserver(() => {
      if (box.clientWidth > 0 && box.clientHeight > 0) {
        chart.setSize({ width: box.clientWidth, height: box.clientHeight });
      }
    });
    watch.observe(box);
    return () => {
      watch.disconnect();
      chart.destroy();
      plot.current = null;
    };
  }, [shape, dark, props.sync]);

  useEffect(() => {
    plot.current?.setData(dataOf(props));
  }, [props.t, props.lines, props.low, props.high]);
  useEffect(() => {
    plot.current?.redraw(false);
  }, [props.at]);
  return <div class="plot" ref={host} aria-hidden="true" />;
}

function mark(chart: uPlot, at: number | null | undefined, color: string): void {
  if (at === null || at === undefined) return;
  const x = chart.valToPos(at, 'x', true);
  const { ctx, bbox } = chart;
  if (!(x >= bbox.left - 1 && x <= bbox.left + bbox.width + 1)) return;
  ctx.save();
  ctx.strokeStyle = color;
  ctx.lineWidth = devicePixelRatio;
  ctx.beginPath();
  ctx.moveTo(x, bbox.top);
  ctx.lineTo(x, bbox.top + bbox.height);
  ctx.stroke();
  ctx.restore();
}
