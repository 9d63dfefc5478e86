/** What a stop or a fault means and what to do then, as keys of the languages. */
import { en, type Key } from '../i18n/en';

export interface Remedy {
  means: Key;
  todo: Key;
}

/** By the error where it says more than the cause of the stop does; nothing where neither is known. */
export function remedyOf(what: { code?: string; cause?: string }): Remedy | null {
  for (const name of [`fault.${what.code}`, `cause.${what.cause}`]) {
    if (`${name}.do` in en) return { means: `${name}.means` as Key, todo: `${name}.do` as Key };
  }
  return null;
}
