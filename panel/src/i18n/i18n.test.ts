import { describe, expect, it } from 'vitest';
import { kLanguages, language, preferredLanguage, t, tWord } from '.';

const holes = (text: string): string[] => [...text.matchAll(/\{(\w+)\}/g)].map((one) => one[1]!).sort();

describe('languages', () => {
  for (const [code, { texts }] of Object.entries(kLanguages)) {
    it(`${code} has every key, no other, and the same holes to fill`, () => {
      const english: Record<string, string> = kLanguages.en.texts;
      expect(Object.keys(texts)).toEqual(Object.keys(english));
      for (const [key, text] of Object.entries(texts)) {
        expect(text.trim(), key).not.toBe('');
        expect(holes(text), key).toEqual(holes(english[key]!));
      }
    });
  }

  it('is the one that was chosen, else the first that the browser knows', () => {
    expect(preferredLanguage('de', ['en-GB'])).toBe('de');
    expect(preferredLanguage(null, ['fr-FR', 'de-CH', 'en'])).toBe('de');
    expect(preferredLanguage('xx', [])).toBe('en');
  });

  it('fills in, and shows words that it does not know as they are', () => {
    language.value = 'de';
    expect(t('live.state', { robot: 'arm', state: 'Bereit' })).toBe('arm: Bereit');
    expect(tWord('state', 'ready')).toBe('Bereit');
    expect(tWord('cause', 'some_new_one')).toBe('some new one');
    language.value = 'en';
  });
});
