/** Rows over time made into lines to look at: what is asked for, in the units that people read. */
import type { Frame, JointFrame, RobotFrame } from './history';
import { toDeg, toMm, type Measure } from './units';

export const kQuantities = ['position', 'velocity', 'acceleration', 'error', 'cycle', 'latency'] as const;
export type Quantity = (typeof kQuantities)[number];
/** Of a joint; the others are of a robot or of the connection. */
export const ofJoints = (quantity: Quantity): boolean => quantity !== 'cycle' && quantity !== 'latency';

export interface Pick {
  robot: string;
  joint: number;
  name: string;
  measure: Measure;
  /** Of all joints that can be chosen: gives its colour, whatever else is chosen. */
  hue: number;
}

export interface Line {
  /** For people and as a column's name: robot.joint or robot. */
  label: string;
  unit: string;
  hue: number;
  values: Float64Array;
}

const kRates: Record<Quantity, string> = {
  position: '',
  velocity: '/s',
  acceleration: '/s²',
  error: '',
  cycle: '',
  latency: '',
};
export const unitText = (quantity: Quantity, measure: Measure): string =>
  ofJoints(quantity) ? (measure === 'length' ? 'mm' : '°') + kRates[quantity] : 'ms';

const kReach = 4;

/**
 * The first or second derivative by a parabola through the four values on either side, by least
 * squares: a sensor's steps and uneven times do not make spikes of it. NaN where fewer than four of
 * them are known, or the times do not differ.
 */
export function derivative(t: ArrayLike<number>, y: ArrayLike<number>, order: 1 | 2): Float64Array {
  const out = new Float64Array(t.length).fill(NaN);
  for (let i = 0; i < t.length; ++i) {
    if (Number.isNaN(y[i]!)) continue;
    let [n, s1, s2, s3, s4, b0, b1, b2] = [0, 0, 0, 0, 0, 0, 0, 0];
    for (let k = Math.max(0, i - kReach); k <= Math.min(t.length - 1, i + kReach); ++k) {
      if (Number.isNaN(y[k]!)) continue;
      const x = t[k]! - t[i]!;
      const v = y[k]! - y[i]!;
      n += 1;
      s1 += x;
      s2 += x * x;
      s3 += x ** 3;
      s4 += x ** 4;
      b0 += v;
      b1 += v * x;
      b2 += v * x * x;
    }
    if (n < 4) continue;
    // Normal equations of c0 + c1 x + c2 x^2, by Cramer's rule.
    const det = n * (s2 * s4 - s3 * s3) - s1 * (s1 * s4 - s2 * s3) + s2 * (s1 * s3 - s2 * s2);
    if (!(Math.abs(det) > 1e-24)) continue;
    const c1 = (n * (b1 * s4 - b2 * s3) - b0 * (s1 * s4 - s2 * s3) + s2 * (s1 * b2 - s2 * b1)) / det;
    const c2 = (n * (s2 * b2 - s3 * b1) - s1 * (s1 * b2 - s2 * b1) + b0 * (s1 * s3 - s2 * s2)) / det;
    out[i] = order === 1 ? c1 : 2 * c2;
  }
  return out;
}

const column = (frames: readonly Frame[], pick: Pick, read: (joint: JointFrame) => number): Float64Array =>
  Float64Array.from(frames, (frame) => {
    const joint = frame.robots[pick.robot]?.joints[pick.joint];
    return joint ? read(joint) : NaN;
  });

function jointLine(frames: readonly Frame[], pick: Pick, quantity: Quantity): Line {
  const at = Float64Array.from(frames, (frame) => frame.robots[pick.robot]?.at ?? NaN);
  let values: Float64Array;
  if (quantity === 'error') {
    values = column(frames, pick, (joint) => (joint.measured ? joint.commanded - joint.position : NaN));
  } else {
    values = column(frames, pick, (joint) => joint.position);
    if (quantity !== 'position') values = derivative(at, values, quantity === 'velocity' ? 1 : 2);
  }
  const shown = pick.measure === 'length' ? toMm : toDeg;
  return {
    label: `${pick.robot}.${pick.name}`,
    unit: unitText(quantity, pick.measure),
    hue: pick.hue,
    values: values.map(shown),
  };
}

/** ms: the longest of its control loop's last cycles; where it does not say, between two samples that came. */
function cycleLine(frames: readonly Frame[], robot: string, hue: number): Line {
  const values = Float64Array.from(frames, (frame) => (frame.robots[robot]?.cycle ?? NaN) * 1e3);
  if (!values.every(Number.isNaN)) return { label: robot, unit: 'ms', hue, values };
  for (let i = 1; i < frames.length; ++i) {
    const now = frames[i]!.robots[robot];
    const before = frames[i - 1]!.robots[robot];
    if (now && before) values[i] = (ourTime(now) - ourTime(before)) * 1e3;
  }
  return { label: robot, unit: 'ms', hue, values };
}

const ourTime = ({ at, scale }: RobotFrame): number => at / (scale ?? 1);

/**
 * By how much each message came later than the quickest one, s. Every robot's clock began at another moment, so each
 * is held against its own quickest; of a message the least late one counts, since the others' loops may be late
 * themselves.
 */
function lateness(frames: readonly Frame[]): Float64Array {
  const least = new Map<string, number>();
  const ways = frames.map((frame) =>
    Object.entries(frame.robots).map(([name, one]) => {
      const way = frame.t - ourTime(one);
      least.set(name, Math.min(way, least.get(name) ?? Infinity));
      return { name, way };
    }),
  );
  return Float64Array.from(ways, (all) =>
    all.length === 0 ? NaN : Math.min(...all.map(({ name, way }) => way - least.get(name)!)),
  );
}

/** The way of a question and its answer, and by how much a message came later than the quickest one. */
function latencyLines(frames: readonly Frame[], names: { trip: string; late: string }): Line[] {
  const trips = Float64Array.from(frames, (one) => one.roundTrip ?? NaN);
  return [
    { label: names.trip, unit: 'ms', hue: 0, values: trips },
    { label: names.late, unit: 'ms', hue: 1, values: lateness(frames).map((one) => one * 1e3) },
  ];
}

export function linesOf(
  frames: readonly Frame[],
  picks: readonly Pick[],
  quantity: Quantity,
  names: { trip: string; late: string },
): Line[] {
  if (quantity === 'latency') return latencyLines(frames, names);
  if (quantity === 'cycle') {
    return [...new Set(picks.map((one) => one.robot))].map((robot, i) => cycleLine(frames, robot, i));
  }
  return picks.map((pick) => jointLine(frames, pick, quantity));
}

/**
 * Fewer points, as high and as low: of each of `most / 2` parts two rows, in which each line has its
 * least and its greatest value in the order in which they came.
 */
export function thinned(t: ArrayLike<number>, lines: readonly Line[], most: number): { t: Float64Array; lines: Line[] } {
  if (t.length <= most) return { t: Float64Array.from(t), lines: [...lines] };
  const parts = Math.max(1, Math.floor(most / 2));
  const time = new Float64Array(2 * parts);
  const edge = (p: number) => Math.floor((p * t.length) / parts);
  for (let p = 0; p < parts; ++p) {
    time[2 * p] = t[edge(p)]!;
    time[2 * p + 1] = t[edge(p + 1) - 1]!;
    // Times of a picture only grow.
    if (!(time[2 * p + 1]! > time[2 * p]!)) time[2 * p + 1] = time[2 * p]! + 1e-9;
  }
  const thin = lines.map((line) => {
    const values = new Float64Array(2 * parts).fill(NaN);
    for (let p = 0; p < parts; ++p) {
      let [low, high] = [-1, -1];
      for (let k = edge(p); k < edge(p + 1); ++k) {
        const value = line.values[k]!;
        if (Number.isNaN(value)) continue;
        if (low < 0 || value < line.values[low]!) low = k;
        if (high < 0 || value > line.values[high]!) high = k;
      }
      if (low < 0) continue;
      values[2 * p] = line.values[Math.min(low, high)]!;
      values[2 * p + 1] = line.values[Math.max(low, high)]!;
    }
    return { ...line, values };
  });
  return { t: time, lines: thin };
}

const kPlain: Record<string, string> = { '°': 'deg', '°/s': 'deg_s', '°/s²': 'deg_s2', mm: 'mm', 'mm/s': 'mm_s', 'mm/s²': 'mm_s2', ms: 'ms' };
const cell = (text: string): string => {
  // A name that a table would take for a formula is none.
  const safe = /^[=+\-@\t\r]/.test(text) ? `'${text}` : text;
  return /[",\n\r]/.test(safe) ? `"${safe.replaceAll('"', '""')}"` : safe;
};

/** What is seen as a table: a row a sample, the unit in each column's name; empty where nobody knows. */
export function csvOf(t: ArrayLike<number>, charts: readonly { quantity: Quantity; lines: readonly Line[] }[]): string {
  const lines = charts.flatMap(({ quantity, lines: all }) =>
    all.map((line) => ({ name: `${line.label}.${quantity}_${kPlain[line.unit] ?? line.unit}`, values: line.values })),
  );
  const rows = [['t_s', ...lines.map((line) => cell(line.name))].join(',')];
  const begin = t[0] ?? 0;
  for (let i = 0; i < t.length; ++i) {
    const row = lines.map((line) => {
      const value = line.values[i]!;
      return Number.isNaN(value) ? '' : String(Number(value.toPrecision(9)));
    });
    rows.push([(t[i]! - begin).toFixed(6), ...row].join(','));
  }
  return rows.join('\n') + '\n';
}
