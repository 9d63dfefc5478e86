/**
 * A program as rows. The text is the truth: rows are read from it, and every change is a change of
 * its lines that leaves all others as they stand.
 */

export interface Row {
  /** From 1, as complaints count. */
  line: number;
  /** How many blocks it is in; `else` and `end` stand as deep as their `loop` or `if`. */
  depth: number;
  /** The step's name; nothing in an empty row and in a remark. */
  word: string;
  /** All words, the step's name too. */
  tokens: string[];
  remark: string;
  /** Of `loop` and `if`: the line of its `end`; itself where that is missing. */
  end?: number;
}

export interface Rows {
  rows: Row[];
  /** Every `loop` and `if` has its `end`. */
  whole: boolean;
}

const kIndent = '  ';

export const linesOf = (text: string): string[] => text.split('\n');

export function splitLine(raw: string): { indent: string; body: string; remark: string } {
  const hash = raw.indexOf('#');
  const code = hash < 0 ? raw : raw.slice(0, hash);
  const indent = /^[ \t]*/.exec(code)![0];
  return { indent, body: code.trim(), remark: hash < 0 ? '' : raw.slice(hash) };
}

export function readRows(text: string): Rows {
  const open: Row[] = [];
  let whole = true;
  const rows = linesOf(text).map((raw, i): Row => {
    const { body, remark } = splitLine(raw);
    const tokens = body === '' ? [] : body.split(/[ \t]+/);
    const word = tokens[0] ?? '';
    const row: Row = { line: i + 1, depth: open.length, word, tokens, remark };
    if (word === 'loop' || word === 'if' || word === 'repeat') {
      row.end = row.line;
      open.push(row);
    } else if (word === 'else' || word === 'end') {
      const opener = open.at(-1);
      if (!opener || (word === 'else' && opener.word !== 'if')) whole = false;
      row.depth = Math.max(0, open.length - 1);
      if (word === 'end' && opener) {
        opener.end = row.line;
        open.pop();
      }
    }
    return row;
  });
  return { rows, whole: whole && open.length === 0 };
}

/** Lines but for the empty one that a text ends with: nothing stands behind that one. */
export function rowCount(text: string): number {
  const lines = linesOf(text);
  return lines.at(-1) === '' ? lines.length - 1 : lines.length;
}

/** The last line that belongs to this one: the `end` of a block, else itself. */
export function lastOf(rows: Rows, line: number): number {
  return rows.rows[line - 1]?.end ?? line;
}

function joined(lines: string[]): string {
  return lines.join('\n');
}

/** With every line two blanks a level deep, as `sinew fmt` lays them out; remarks behind stay. */
export function indented(text: string, from = 1, to = Infinity): string {
  const { rows } = readRows(text);
  const lines = linesOf(text).map((raw, i) => {
    const row = rows[i]!;
    if (row.line < from || row.line > to || (row.word === '' && row.remark === '')) return raw;
    return kIndent.repeat(row.depth) + raw.trim();
  });
  return joined(lines);
}

export interface Change {
  text: string;
  /** Where what was changed stands now. */
  line: number;
}

/**
 * A row, with all of its block, before the line `wish`; behind the last one where that is one more.
 * @return  nothing where it stands there already, or where blocks would not fit any more
 */
export function moveRow(text: string, line: number, wish: number): Change | null {
  const rows = readRows(text);
  const last = lastOf(rows, line);
  const before = Math.min(wish, rowCount(text) + 1);
  if (before >= line && before <= last + 1) return null;
  const lines = linesOf(text);
  const moved = lines.slice(line - 1, last);
  const at = before > line ? before - moved.length : before;
  const rest = [...lines.slice(0, line - 1), ...lines.slice(last)];
  rest.splice(at - 1, 0, ...moved);
  const next = joined(rest);
  if (rows.whole && !readRows(next).whole) return null;
  return { text: indented(next, at, at + moved.length - 1), line: at };
}

/** One place up or down among its neighbours: over a whole block, or into one and out of it. */
export function stepRow(text: string, line: number, way: -1 | 1): Change | null {
  const rows = readRows(text);
  const last = lastOf(rows, line);
  const count = rowCount(text);
  for (let before = way < 0 ? line - 1 : last + 2; before >= 1 && before <= count + 1; before += way) {
    const change = moveRow(text, line, before);
    if (change) return change;
  }
  return null;
}

/** Rows behind a line, or at the beginning behind line 0; as deep as what stands there. */
export function insertRows(text: string, behind: number, rows: string[]): Change {
  const lines = linesOf(text);
  const at = Math.min(behind, rowCount(text));
  lines.splice(at, 0, ...rows);
  const next = joined(lines);
  const whole = lines.at(-1) === '' ? next : `${next}\n`;
  return { text: indented(whole, at + 1, at + rows.length), line: at + 1 };
}

/** A row goes, of a block all of it. */
export function removeRow(text: string, line: number): string {
  const last = lastOf(readRows(text), line);
  const lines = linesOf(text);
  lines.splice(line - 1, last - line + 1);
  return joined(lines);
}

export function copyRow(text: string, line: number): Change {
  const last = lastOf(readRows(text), line);
  return insertRows(text, last, linesOf(text).slice(line - 1, last));
}

/** Which word of a row something stands in. */
export type Slot = { at: number } | KeySlot;
interface KeySlot {
  /** `key=` */
  key: string;
  /** Another name of the same, as rows by hand may have it. */
  also?: string;
  /** Where a key may come twice (speed): what its value ends with. */
  unit?: RegExp;
}

const fits = (slot: KeySlot, token: string): boolean => {
  const key = token.slice(0, Math.max(0, token.indexOf('=')));
  return key !== '' && (key === slot.key || key === slot.also) && (!slot.unit || slot.unit.test(token));
};

export function readSlot(tokens: readonly string[], slot: Slot): string {
  if ('at' in slot) return tokens[slot.at] ?? '';
  const token = tokens.find((one, i) => i > 0 && fits(slot, one));
  return token ? token.slice(token.indexOf('=') + 1) : '';
}

/** The line with another value there; an empty one takes the word away. */
export function writeSlot(raw: string, slot: Slot, value: string): string {
  const { indent, body, remark } = splitLine(raw);
  const tokens = body === '' ? [] : body.split(/[ \t]+/);
  const index = 'at' in slot ? slot.at : tokens.findIndex((one, i) => i > 0 && fits(slot, one));
  const token = 'at' in slot ? value : `${slot.key}=${value}`;
  if (value === '') {
    if (index > 0 && index < tokens.length) tokens.splice(index, 1);
  } else if (index > 0 && index < tokens.length) {
    tokens[index] = token;
  } else {
    tokens.push(token);
  }
  return indent + tokens.join(' ') + (remark ? `  ${remark}` : '');
}

export function replaceLine(text: string, line: number, raw: string): string {
  const lines = linesOf(text);
  lines[line - 1] = raw;
  return joined(lines);
}
