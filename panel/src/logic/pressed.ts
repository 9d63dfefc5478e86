import type { Note } from './store';

/** ms behind a press in which a refusal is taken for its answer. */
export const kAnswerTime = 15_000;

/** The newest refusal since a button was pressed, where it may be meant for that button. */
export function answerTo(notes: readonly Note[], pressed: { at: number; lastNote: number }): Note | null {
  const newest = notes.filter((one) => one.kind !== 'info' && one.id > pressed.lastNote).at(-1);
  return newest && newest.at - pressed.at <= kAnswerTime ? newest : null;
}

export interface Box {
  left: number;
  top: number;
  width: number;
  height: number;
}

const kGap = 6;

/** Where a card of that size lies beside a button, px: below it, or above where there is no room; never over it. */
export function beside(button: Box, card: { width: number; height: number }, page: { width: number; height: number }) {
  const below = button.top + button.height + kGap;
  const above = button.top - kGap - card.height;
  const top = below + card.height <= page.height || above < 0 ? below : above;
  const left = Math.min(Math.max(kGap, button.left), Math.max(kGap, page.width - card.width - kGap));
  return { left, top };
}
