/** What the server said to a program, row by row: of the rows that stand in its text, whatever they call. */
import { calledBy, calledIn, type Expanded, type Missing } from './expand';
import { linesOf, readRows } from './rows';
import type { CheckJson, CheckRow, PreviewJson, RefusalData } from './types';

/** Why a row is refused. */
export interface Why {
  sentence: string;
  data: RefusalData | null;
  /** Of a file of points, dotted. */
  key?: string;
  /** Where it stands, if that is in a called program. */
  file?: string;
  line?: number;
  /** Of its loop, where that is not the first. */
  round?: number;
  /** The page says it better, in its own words. */
  missing?: Missing;
}

/** What a check said, and of which text: one that was changed since has no verdicts. */
export interface Judged {
  text: string;
  check: CheckJson;
  rows: Record<number, RowVerdict>;
}

export type ProgramVerdict =
  | { kind: 'none' }
  | { kind: 'checking' }
  /**
   * It may run. `preview` is what the 3D view shows of it, where there is one: never of rows that only a run can
   * place (`hidden`), and not where it was refused (`unseen`).
   */
  | { kind: 'fine'; judged: Judged | null; preview: PreviewJson | null; hidden: readonly number[]; unseen?: Why }
  /** `line` is the program's own; `more` rows are refused beside that one. */
  | { kind: 'refused'; judged: Judged | null; why: Why; line: number | null; more: number }
  | { kind: 'lost' };

/** What is told of a row: `text`: nothing of this program could be read; `end`: the check ended before. */
export interface RowVerdict {
  verdict: 'fine' | 'refused' | 'unchecked';
  /** s, of a motion that begins here, or of all that is called. */
  time?: { least: number; most: number };
  /** It is one motion with this row. */
  withLine?: number;
  why?: Why;
  because?: { line: number; file?: string } | 'text' | 'end';
}

/** Of a preview that was refused: rows by the lines that were expanded into it. */
export function refusal(message: string, data: unknown, expanded: Expanded): ProgramVerdict {
  const told = (data ?? null) as RefusalData | null;
  const line = told?.line ?? null;
  return {
    kind: 'refused',
    judged: null,
    why: { sentence: message, data: told },
    line: line === null ? null : (expanded.lines[line - 1] ?? null),
    more: 0,
  };
}

/** A text that cannot be read is not planned, and has no times. */
const couldRead = (check: CheckJson): boolean => check.duration_min_s !== undefined;

export function judged(
  text: string,
  check: CheckJson,
  programs: Readonly<Record<string, string>>,
  expanded: Pick<Expanded, 'missing' | 'open'>,
): ProgramVerdict {
  const rows = judgeRows(text, check, programs, expanded.missing);
  const whole: Judged = { text, check, rows };
  if (check.fine) return { kind: 'fine', judged: whole, preview: null, hidden: expanded.open };
  const refused = Object.entries(rows).flatMap(([line, row]) =>
    row.verdict === 'refused' ? [{ line: Number(line), why: row.why! }] : [],
  );
  const first = refused[0];
  if (first) return { kind: 'refused', judged: whole, ...first, more: refused.length - 1 };
  // It stands in no row: too long a program, or a file of points that cannot be read.
  const other = check.broken_off ? whyOf({ ...check.broken_off }) : whyOf(check.rows[0] ?? {});
  return { kind: 'refused', judged: whole, why: other, line: null, more: 0 };
}

export function judgeRows(
  text: string,
  check: CheckJson,
  programs: Readonly<Record<string, string>>,
  missing: readonly Missing[] = [],
): Record<number, RowVerdict> {
  const told = byOwnLine(text, check, programs);
  const verdicts: Record<number, RowVerdict> = {};
  for (const row of readRows(text).rows) {
    if (row.word === '') continue;
    const own = told.get(row.line);
    if (own) {
      verdicts[row.line] = worst(own, missing.find((one) => one.line === row.line));
    } else if (!couldRead(check)) {
      verdicts[row.line] = { verdict: 'unchecked', because: 'text' };
    } else if (check.broken_off) {
      verdicts[row.line] = { verdict: 'unchecked', because: 'end' };
    } else {
      // Loops and the like do nothing by themselves.
      verdicts[row.line] = { verdict: 'fine' };
    }
  }
  return verdicts;
}

/** A row, or all that it calls: what is worst of it counts. */
function worst(rows: readonly CheckRow[], missing: Missing | undefined): RowVerdict {
  const refused = rows.find((one) => one.verdict === 'refused');
  if (refused) return { verdict: 'refused', why: { ...whyOf(refused), ...(missing && !refused.refusal ? { missing } : {}) } };
  const blind = rows.find((one) => one.verdict === 'not_checked');
  if (blind) {
    const { line, file } = blind.because ?? {};
    return { verdict: 'unchecked', ...(line === undefined ? {} : { because: { line, ...(file ? { file } : {}) } }) };
  }
  const begin = rows.filter((one) => one.motion_of_line === undefined && one.time_max_s !== undefined);
  if (begin.length === 0) {
    const withLine = rows[0]?.motion_of_line;
    return { verdict: 'fine', ...(withLine === undefined ? {} : { withLine }) };
  }
  const sum = (read: (row: CheckRow) => number) => begin.reduce((all, one) => all + read(one), 0);
  return { verdict: 'fine', time: { least: sum((one) => one.time_min_s ?? 0), most: sum((one) => one.time_max_s!) } };
}

function whyOf(row: Partial<CheckRow>): Why {
  const { sentence = '', refusal: data = null, key, file, line, round } = row;
  return { sentence, data, ...(key ? { key } : {}), ...(file ? { file, line } : {}), ...(round ? { round } : {}) };
}

interface Place {
  own: number;
  file?: string;
  line: number;
}

/**
 * Rows of called programs belong to the row that calls them. They come in the order in which they are run, so that
 * two calls of one program are told apart; a complaint of a called text belongs to every row that calls it.
 */
function byOwnLine(text: string, check: CheckJson, programs: Readonly<Record<string, string>>): Map<number, CheckRow[]> {
  const told = new Map<number, CheckRow[]>();
  const put = (own: number, row: CheckRow) => {
    if (!told.has(own)) told.set(own, []);
    told.get(own)!.push(row);
  };
  const places = couldRead(check) ? placesOf(text, programs) : [];
  let at = 0;
  for (const row of check.rows) {
    const next = places.findIndex((one, i) => i >= at && one.file === row.file && one.line === row.line);
    if (next >= 0) {
      put(places[next]!.own, row);
      at = next + 1;
    } else if (row.file === undefined) {
      put(row.line, row);
    } else {
      for (const own of callsOf(text, row.file, programs)) put(own, row);
    }
  }
  return told;
}

const kDepthMax = 32;

/** Every row as it is run, calls with what they call. */
function placesOf(text: string, programs: Readonly<Record<string, string>>): Place[] {
  const places: Place[] = [];
  const walk = (part: string, file: string | undefined, own: number | null, depth: number) => {
    linesOf(part).forEach((raw, i) => {
      const line = i + 1;
      const called = calledIn(raw);
      places.push({ own: own ?? line, file, line });
      if (called !== undefined && Object.hasOwn(programs, called) && depth < kDepthMax) {
        walk(programs[called]!, called, own ?? line, depth + 1);
      }
    });
  };
  walk(text, undefined, null, 0);
  return places;
}

/** Rows of the program itself that call another one, by others or not. */
function callsOf(text: string, file: string, programs: Readonly<Record<string, string>>): number[] {
  return linesOf(text).flatMap((raw, i) => (calledIn(raw) !== undefined && file in calledBy(raw, programs) ? [i + 1] : []));
}
