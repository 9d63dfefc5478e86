import { describe, expect, it } from 'vitest';
import { en } from '../i18n/en';
import { isFirstRun, kTour, nextStep, rememberTour, type Kept } from './tour';

describe('the tour', () => {
  it('comes once', () => {
    const all = new Map<string, string>();
    const kept: Kept = { getItem: (key) => all.get(key) ?? null, setItem: (key, value) => void all.set(key, value) };
    expect(isFirstRun(kept)).toBe(true);
    rememberTour(kept);
    expect(isFirstRun(kept)).toBe(false);
  });

  it('does not come again and again where nothing is kept', () => {
    const closed: Kept = {
      getItem: () => {
        throw new Error('denied');
      },
      setItem: () => {
        throw new Error('denied');
      },
    };
    expect(isFirstRun(closed)).toBe(false);
    expect(() => rememberTour(closed)).not.toThrow();
  });

  it('has five steps with words, ends behind the last and stays before the first', () => {
    expect(kTour).toHaveLength(5);
    for (const { id } of kTour) {
      expect(en[`tour.${id}.title`]).toBeTruthy();
      expect(en[`tour.${id}.text`]).toBeTruthy();
    }
    expect(nextStep(0, 1)).toBe(1);
    expect(nextStep(0, -1)).toBe(0);
    expect(nextStep(4, 1)).toBeNull();
  });
});
