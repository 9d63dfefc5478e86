import { describe, expect, it } from 'vitest';
import { fitted, hold, kSpanMin, shift, shownOf, zoom } from './plot_window';

const live = { span: 10, held: null };

describe('the window of plots', () => {
  it('follows the newest until it is held', () => {
    expect(shownOf(live, 100)).toEqual({ low: 90, high: 100 });
    const held = hold(live, 100);
    expect(shownOf(held, 120)).toEqual({ low: 90, high: 100 });
  });
  it('zooms about its middle and stays within what is known', () => {
    expect(zoom(live, 100, 0, 0.5).held).toEqual({ low: 92.5, high: 97.5 });
    const wide = zoom(live, 100, 80, 10).held!;
    expect(wide).toEqual({ low: 80, high: 100 });
    const near = zoom(live, 100, 0, 1e-9).held!;
    expect(near.high - near.low).toBeCloseTo(kSpanMin);
  });
  it('goes earlier and later, not beyond the ends', () => {
    expect(shift(live, 100, 0, -0.5).held).toEqual({ low: 85, high: 95 });
    expect(shift(live, 100, 88, -0.5).held).toEqual({ low: 88, high: 98 });
    expect(shift(live, 100, 0, 3).held).toEqual({ low: 90, high: 100 });
  });
  it('is never empty, whatever is dragged', () => {
    const one = fitted(5, 5, 0, 10);
    expect(one.high).toBeGreaterThan(one.low);
    expect(fitted(-20, 40, 0, 10)).toEqual({ low: 0, high: 10 });
  });
});
