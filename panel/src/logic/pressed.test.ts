import { describe, expect, it } from 'vitest';
import { answerTo, beside, kAnswerTime } from './pressed';
import type { Note } from './store';

const note = (id: number, at: number, kind: Note['kind'] = 'refused'): Note => ({ id, at, kind, text: `${id}` });

describe('a press and its answer', () => {
  const pressed = { at: 1000, lastNote: 3 };
  it('is the newest refusal behind it', () => {
    expect(answerTo([note(3, 900), note(4, 1100), note(5, 1200)], pressed)?.id).toBe(5);
  });
  it('is none where nothing was refused since, or long after', () => {
    expect(answerTo([note(3, 1100)], pressed)).toBeNull();
    expect(answerTo([note(4, 1100, 'info')], pressed)).toBeNull();
    expect(answerTo([note(4, 1001 + kAnswerTime)], pressed)).toBeNull();
  });
});

describe('its card', () => {
  const page = { width: 1000, height: 600 };
  const card = { width: 300, height: 80 };
  it('lies below the button, above it at the bottom, and inside the page', () => {
    expect(beside({ left: 100, top: 100, width: 80, height: 30 }, card, page)).toEqual({ left: 100, top: 136 });
    expect(beside({ left: 100, top: 560, width: 80, height: 30 }, card, page)).toEqual({ left: 100, top: 474 });
    expect(beside({ left: 950, top: 100, width: 40, height: 30 }, card, page).left).toBe(694);
    expect(beside({ left: 0, top: 100, width: 40, height: 30 }, { width: 2000, height: 80 }, page).left).toBe(6);
  });
});
