/**
 * What the server complains of in a text, in another language than its own. It says it in English and tells no code:
 * its sentence is known by its words. Where none fits, the English one stays.
 */

/** A language's words for complaints. `{name}` is what the server fills in, and stays as it is. */
export interface ComplaintWords {
  /** By the English sentence; the first one that fits counts. `{word}` is a word of the text in its quotation marks. */
  sentences: Readonly<Record<string, string>>;
  /** With what a sentence may go on, behind a semicolon or a colon. */
  endings: Readonly<Record<string, string>>;
  /** The server's own words in what it fills in, by the name of that. */
  parts: Readonly<Record<string, Readonly<Record<string, string>>>>;
}

export type ComplaintReader = (sentence: string) => string | undefined;

const kHole = /\{(\w+)\}/g;

/** @param before  what the expression says of all that stands before the template */
function compiled(template: string, before = ''): RegExp {
  const plain = template.replace(/[.*+?^$()|[\]\\]/g, '\\$&');
  return new RegExp(`^${before}${plain.replace(kHole, (_, name: string) => (name === 'word' ? "(?<word>'.*?')" : `(?<${name}>.+?)`))}$`);
}

export function complaintReader({ sentences, endings, parts }: ComplaintWords): ComplaintReader {
  const rows = Object.entries(sentences).map(([english, other]) => ({ fits: compiled(english), other }));
  const ends = Object.entries(endings).map(([english, other]) => ({ fits: compiled(english, '(?<begin>.+)(?<mark>[;:]) '), other }));
  const part = (name: string, value: string): string =>
    Object.entries(parts[name] ?? {}).reduce((text, [english, other]) => text.replaceAll(english, other), value);
  const filled = (other: string, values: Readonly<Record<string, string>>): string =>
    other.replace(kHole, (_, name: string) => part(name, values[name] ?? ''));

  const read: ComplaintReader = (sentence) => {
    for (const { fits, other } of rows) {
      const found = fits.exec(sentence);
      if (found) return filled(other, found.groups ?? {});
    }
    for (const { fits, other } of ends) {
      const { begin, mark, ...values } = fits.exec(sentence)?.groups ?? {};
      const begun = begin && read(begin);
      if (begun) return `${begun}${mark} ${filled(other, values as Record<string, string>)}`;
    }
    return undefined;
  };
  return read;
}
