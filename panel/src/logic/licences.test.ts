import { describe, expect, it } from 'vitest';
import pack from '../../package.json';
import { kProgramParts, pageParts } from './licences';

describe('licences', () => {
  it('are known of every part that the page is built from', () => {
    const parts = pageParts(pack.dependencies);
    expect(parts.length).toBe(Object.keys(pack.dependencies).length);
    expect(parts.filter((one) => one.licence === '?')).toEqual([]);
    for (const one of [...parts, ...kProgramParts]) {
      if (one.licence !== 'BSL-1.0') expect(one.text, one.name).toMatch(/Copyright[\s\S]{700,}/);
      if (one.licence === 'MIT') expect(one.text, one.name).toContain('Permission is hereby granted');
    }
    expect(pageParts({ something: '1' })[0]!.licence).toBe('?');
  });
});
