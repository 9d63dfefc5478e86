import { signal } from '@preact/signals';
import { de } from './de';
import { en, type Key } from './en';

/** A language is a file and a row here. */
export const kLanguages = { en: { name: 'English', texts: en }, de: { name: 'Deutsch', texts: de } } as const;
export type Language = keyof typeof kLanguages;

export const language = signal<Language>('en');

export function preferredLanguage(kept: string | null, browser: readonly string[]): Language {
  for (const wish of [kept, ...browser]) {
    const code = wish?.slice(0, 2).toLowerCase();
    if (code && code in kLanguages) return code as Language;
  }
  return 'en';
}

/** The text of a key in the language at hand. */
export function t(key: Key, values: Record<string, string | number> = {}): string {
  const text: string = kLanguages[language.value].texts[key];
  return text.replace(/\{(\w+)\}/g, (_, name: string) => String(values[name] ?? ''));
}

/** Of a name that came over the wire; the name itself where this page does not know it. */
export function tWord(prefix: string, word: string, values: Record<string, string | number> = {}): string {
  const key = `${prefix}.${word}`;
  return key in en ? t(key as Key, values) : word.replaceAll('_', ' ');
}

export type { Key };
