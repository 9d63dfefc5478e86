/** The messages of a wire as they come from `wire.read`: kept, chosen, written down. */

export interface WireFrame {
  sequence: number;
  at_s: number;
  to: 'device' | 'host';
  axes?: number[];
  hex: string;
  name: string;
  fields: [string, string | number][];
  text: string;
  kind: 'good' | 'fill' | 'bad';
}

export interface WireAnswer {
  frames: WireFrame[];
  last: number;
  lost: number;
  at_s: number;
}

export const kFramesKept = 2000;

export interface WireFilter {
  way: 'both' | 'device' | 'host';
  words: string;
  /** Transfers in which only the other side speaks. */
  fill: boolean;
}

const hexOnly = (text: string): string => text.toLowerCase().replace(/0x|[\s,]/g, '');

export const axesText = (frame: WireFrame, between: string): string => (frame.axes ?? []).map((one) => `J${one}`).join(between);

/** Each word of the filter is an axis or in the sentence, or they are bytes that stand one behind the other. */
export function matches(frame: WireFrame, filter: WireFilter, sentence: string): boolean {
  if (filter.way !== 'both' && filter.way !== frame.to) return false;
  if (!filter.fill && frame.kind === 'fill') return false;
  const words = filter.words.trim().toLowerCase();
  if (words === '') return true;
  const text = `${sentence} ${frame.text}`.toLowerCase();
  const axes = axesText(frame, ' ').toLowerCase().split(' ');
  if (words.split(/\s+/).every((word) => axes.includes(word) || text.includes(word))) return true;
  const bytes = hexOnly(words);
  if (!/^(?:[0-9a-f]{2})+$/.test(bytes)) return false;
  // Whole bytes only: "05" is not in "50 55".
  return ` ${frame.hex.toLowerCase()} `.includes(` ${bytes.match(/../g)!.join(' ')} `);
}

/** What is kept of what was there and what has come. */
export function appended(kept: readonly WireFrame[], came: readonly WireFrame[]): WireFrame[] {
  const last = kept.at(-1)?.sequence ?? 0;
  return [...kept, ...came.filter((one) => one.sequence > last)].slice(-kFramesKept);
}

/** Rows of a long list that can be seen, and some beyond them. */
export function visible(count: number, rowHeight: number, top: number, height: number): { first: number; end: number } {
  const first = Math.max(0, Math.floor(top / rowHeight) - 8);
  return { first, end: Math.min(count, Math.ceil((top + height) / rowHeight) + 8) };
}

/** As a text file: a row a message, gaps told where they are. */
export function fileText(head: string, frames: readonly WireFrame[], sentence: (frame: WireFrame) => string): string {
  const rows = [head, '# seconds  way  axis  bytes (hex)  message'];
  for (const frame of frames) {
    const way = frame.to === 'device' ? 'host -> device' : 'device -> host';
    const axis = axesText(frame, '+') || '-';
    rows.push(`${frame.at_s.toFixed(6).padStart(14)}  ${way}  ${axis}  ${frame.hex}  ${sentence(frame)}`);
  }
  return `${rows.join('\n')}\n`;
}
