import { describe, expect, it } from 'vitest';
import { parseRoute, routeText, tokenOf } from './router';

const kViews = ['jog', 'move', 'events'];

describe('routes', () => {
  it('come back as they were written', () => {
    for (const route of [
      { robot: 'arm', view: 'move' },
      { robot: null, view: 'events' },
    ]) {
      expect(parseRoute(routeText(route), kViews)).toEqual(route);
    }
  });
  it('fall back to what there is', () => {
    expect(parseRoute('', kViews)).toEqual({ robot: null, view: 'jog' });
    expect(parseRoute('#/robots/arm/wizards', kViews)).toEqual({ robot: 'arm', view: 'jog' });
    expect(parseRoute('#/robots/<b>/move', kViews)).toEqual({ robot: null, view: 'move' });
  });
});

describe('tokenOf', () => {
  it('is read from the start link only', () => {
    expect(tokenOf('#token=abcDEF0123456789')).toBe('abcDEF0123456789');
    expect(tokenOf('#/robots/arm/jog')).toBeNull();
    expect(tokenOf('#token=<script>')).toBeNull();
  });
});
