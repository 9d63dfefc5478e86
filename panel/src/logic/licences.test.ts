import { describe, expect, it } from 'vitest';
import pack from '../../package.json';
import { pageParts } from './licences';

describe('licences', () => {
  it('are known of every part that the page is built from', () => {
    const parts = pageParts(pack.dependencies);
    expect(parts.length).toBe(Object.keys(pack.dependencies).length);
    expect(parts.filter((one) => one.licence === '?')).toEqual([]);
    expect(pageParts({ something: '1' })[0]!.licence).toBe('?');
  });
});
