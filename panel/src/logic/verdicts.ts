/** What the server said to a program, row by row. */
import type { Expanded } from './expand';
import { readRows } from './rows';
import type { PreviewJson, RefusalData } from './types';

export type ProgramVerdict =
  | { kind: 'none' }
  | { kind: 'checking' }
  | { kind: 'fine'; preview: PreviewJson }
  /** `line` is the program's own. */
  | { kind: 'refused'; sentence: string; line: number | null; data: RefusalData | null }
  /** Some rows cannot be asked about beforehand; a run checks them before anything moves. */
  | { kind: 'unsure'; lines: number[] }
  | { kind: 'lost' };

export type RowVerdict = 'fine' | 'refused' | 'unchecked';

/** "preview:3:1: unknown step": what is wrong with a text stands behind its line and column. */
const kComplaint = /^preview:(\d+):\d+: ([\s\S]*)$/;

export function refusal(message: string, data: unknown, expanded: Expanded): ProgramVerdict {
  const told = (data ?? null) as RefusalData | null;
  const complaint = kComplaint.exec(message);
  const line = complaint ? Number(complaint[1]) : (told?.line ?? null);
  return {
    kind: 'refused',
    sentence: complaint ? complaint[2]! : message,
    line: line === null ? null : (expanded.lines[line - 1] ?? null),
    data: told,
  };
}

/**
 * Planning goes from the first row on and ends at the first that is refused: what stands behind that one
 * was not looked at. A text with a mistake is not planned at all.
 */
export function rowVerdicts(text: string, verdict: ProgramVerdict): Record<number, RowVerdict> {
  const told: Record<number, RowVerdict> = {};
  if (verdict.kind !== 'fine' && verdict.kind !== 'refused') return told;
  const bad = verdict.kind === 'refused' ? verdict.line : null;
  const planned = verdict.kind === 'fine' || verdict.data?.code !== undefined;
  for (const row of readRows(text).rows) {
    if (row.word === '') continue;
    if (verdict.kind === 'fine') told[row.line] = 'fine';
    else if (row.line === bad) told[row.line] = 'refused';
    else told[row.line] = planned && bad !== null && row.line < bad ? 'fine' : 'unchecked';
  }
  return told;
}
