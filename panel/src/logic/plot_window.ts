/** Which seconds of all that is known are in the picture. Live it follows the newest; zoomed it stands. */

export const kSpans = [10, 60, 300] as const;
export const kSpanMin = 0.2;

export interface PlotWindow {
  /** s that are shown while it follows. */
  span: number;
  /** It stands: from here to there, s; nothing: it follows. */
  held: { low: number; high: number } | null;
}

export const shownOf = (now: PlotWindow, newest: number): { low: number; high: number } =>
  now.held ?? { low: newest - now.span, high: newest };

export function hold(now: PlotWindow, newest: number): PlotWindow {
  return { ...now, held: shownOf(now, newest) };
}

/** @param factor  below 1: nearer. About its middle; never beyond what is known. */
export function zoom(now: PlotWindow, newest: number, oldest: number, factor: number): PlotWindow {
  const { low, high } = shownOf(now, newest);
  const middle = (low + high) / 2;
  const span = Math.max(kSpanMin, (high - low) * factor);
  return { ...now, held: fitted(middle - span / 2, middle + span / 2, oldest, newest) };
}

/** @param share  of what is shown; negative: earlier */
export function shift(now: PlotWindow, newest: number, oldest: number, share: number): PlotWindow {
  const { low, high } = shownOf(now, newest);
  const way = (high - low) * share;
  return { ...now, held: fitted(low + way, high + way, oldest, newest) };
}

export function fitted(low: number, high: number, oldest: number, newest: number): { low: number; high: number } {
  const span = Math.min(Math.max(high - low, kSpanMin), Math.max(newest - oldest, kSpanMin));
  const begin = Math.min(Math.max(low, oldest), Math.max(oldest, newest - span));
  return { low: begin, high: begin + span };
}
