import { describe, expect, it } from 'vitest';
import { firstOf, newestFirst } from './paging';

describe('a page of a long list', () => {
  it('has the newest first, and says how many are left out', () => {
    expect(newestFirst([1, 2, 3, 4, 5], 2)).toEqual({ shown: [5, 4], more: 3 });
    expect(newestFirst([1, 2], 2)).toEqual({ shown: [2, 1], more: 0 });
    expect(newestFirst([], 2)).toEqual({ shown: [], more: 0 });
  });
  it('has its beginning', () => {
    expect(firstOf([1, 2, 3], 2)).toEqual({ shown: [1, 2], more: 1 });
    expect(firstOf([1, 2], 5)).toEqual({ shown: [1, 2], more: 0 });
  });
});
