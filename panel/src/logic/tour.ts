/** The tour: where each step points, and whether somebody has seen it. */

export interface TourStep {
  id: 'robots' | 'stop' | 'enable' | 'move' | 'programs';
  /** What it points at: the first of these that is on the page. */
  at: readonly string[];
}

export const kTour: readonly TourStep[] = [
  { id: 'robots', at: ['[data-tour=robots]'] },
  { id: 'stop', at: ['[data-tour=stop]'] },
  { id: 'enable', at: ['[data-tour=enable]', '.card.chosen .card-actions'] },
  { id: 'move', at: ['.tabs a[href$="/move"]', '.tabs'] },
  { id: 'programs', at: ['.tabs a[href$="/programs"]', '.tabs'] },
];

const kKey = 'sinew.tour';

export interface Kept {
  getItem(key: string): string | null;
  setItem(key: string, value: string): void;
}

/** It comes once by itself; a browser that keeps nothing shows none rather than always. */
export function isFirstRun(kept: Kept): boolean {
  try {
    return kept.getItem(kKey) === null;
  } catch {
    return false;
  }
}
export function rememberTour(kept: Kept): void {
  try {
    kept.setItem(kKey, 'seen');
  } catch {
    // Then it comes again.
  }
}

/** The step behind this one or before it; nothing behind the last. */
export function nextStep(step: number, way: 1 | -1): number | null {
  const next = step + way;
  return next >= kTour.length ? null : Math.max(0, next);
}
