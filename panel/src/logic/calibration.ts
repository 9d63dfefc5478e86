/** What the calibration wizard knows of printed sheets and of figures. */
import type { Calibration } from './types';

/** Tags of the sheet for the table; all others are the board's. */
export const kSheetTags: ReadonlySet<number> = new Set([580, 581, 582, 583]);

/** How far a view's residual reaches on its bar, 0 to 1. Above 1 px rms a view is poor. */
export const residualShare = (px: number): number => Math.min(1, px / 1.333);

/** The mark to touch next: the one that says most, else the first one that was not touched. */
export function nextMark(now: Calibration | null): string | null {
  const touched = new Set(now?.touch?.marks.map((one) => one.mark));
  if (now?.touch?.next) return now.touch.next.mark;
  return now?.marks?.find((one) => !touched.has(one.mark))?.mark ?? null;
}
