import { describe, expect, it } from 'vitest';
import { judged, judgeRows, refusal } from './verdicts';
import type { CheckJson, CheckRow } from './types';

const none = { missing: [], open: [] };
const row = (line: number, more: Partial<CheckRow> = {}): CheckRow => ({
  line,
  column: 1,
  verdict: 'fine',
  time_min_s: 1,
  time_max_s: 1,
  ...more,
});
const bad = (line: number, sentence: string, more: Partial<CheckRow> = {}): CheckRow => ({
  line,
  column: 1,
  verdict: 'refused',
  sentence,
  refusal: { code: 'out_of_reach', sentence, line },
  ...more,
});
const blind = (line: number, because: number, more: Partial<CheckRow> = {}): CheckRow => ({
  line,
  column: 1,
  verdict: 'not_checked',
  because: { line: because, column: 1 },
  ...more,
});
const check = (rows: CheckRow[], more: Partial<CheckJson> = {}): CheckJson => ({
  fine: rows.every((one) => one.verdict === 'fine'),
  duration_min_s: 2,
  duration_max_s: 3,
  homing_at_most_s: 0,
  rows,
  ...more,
});
const kinds = (told: ReturnType<typeof judgeRows>) => Object.fromEntries(Object.entries(told).map(([line, one]) => [line, one.verdict]));

describe('the rows of a program that was checked', () => {
  const text = '# it\njoint base=10deg\nline z=900mm\nline dz=5mm\nloop 2\n  line z=999mm\nend\njoint base=0deg\n';
  const rows = [row(2, { time_min_s: 1.4, time_max_s: 1.4 }), bad(3, 'too far'), blind(4, 3), bad(6, 'much too far', { round: 2 }), row(8)];

  it('have each its own verdict, behind a refused one too', () => {
    const told = judgeRows(text, check(rows), {});
    expect(kinds(told)).toEqual({ 2: 'fine', 3: 'refused', 4: 'unchecked', 5: 'fine', 6: 'refused', 7: 'fine', 8: 'fine' });
    expect(told[3]!.why).toMatchObject({ sentence: 'too far', data: { code: 'out_of_reach' } });
    expect(told[4]!.because).toEqual({ line: 3 });
    expect(told[6]!.why).toMatchObject({ sentence: 'much too far', round: 2 });
  });

  it('have a time where a motion begins, and a row that goes on with it has none', () => {
    const rows = [row(1), row(2, { time_max_s: 2 }), row(3, { motion_of_line: 2, time_min_s: 0, time_max_s: 0 })];
    const told = judgeRows('joint base=1deg\nline dz=1mm blend=5mm\nline dz=1mm', check(rows), {});
    expect(told[1]!.time).toEqual({ least: 1, most: 1 });
    expect(told[2]!.time).toEqual({ least: 1, most: 2 });
    expect(told[3]).toEqual({ verdict: 'fine', withLine: 2 });
  });

  it('make a program that may run only where all are fine', () => {
    const good = check([row(2)]);
    expect(judged(text, good, {}, { missing: [], open: [4] })).toMatchObject({
      kind: 'fine',
      preview: null,
      hidden: [4],
      judged: { text, check: good },
    });
    expect(judged(text, check(rows), {}, none)).toMatchObject({ kind: 'refused', line: 3, more: 1, why: { sentence: 'too far' } });
  });
});

describe('rows of called programs', () => {
  const text = 'call grip\nwait 1s\ncall grip\ncall grip\n';
  const programs = { grip: 'jaws 20mm\nwait settled\n', other: 'call grip\n' };
  const grip = (line: number, more: Partial<CheckRow> = {}) => row(line, { file: 'grip', ...more });

  it('belong to the row that calls them, of several calls to the one they were run for', () => {
    const because = { line: 2, column: 1, file: 'grip' };
    const third = [grip(1), bad(2, 'no', { file: 'grip' })];
    const fourth = [blind(1, 2, { file: 'grip', because }), grip(2)];
    const rows = [grip(1), grip(2), row(2), ...third, ...fourth];
    const told = judgeRows(text, check(rows), programs);
    expect(kinds(told)).toEqual({ 1: 'fine', 2: 'fine', 3: 'refused', 4: 'unchecked' });
    expect(told[1]!.time).toEqual({ least: 2, most: 2 });
    expect(told[3]!.why).toMatchObject({ sentence: 'no', file: 'grip', line: 2 });
    expect(told[4]!.because).toEqual({ line: 2, file: 'grip' });
  });

  it('are found through others', () => {
    const told = judgeRows('wait 1s\ncall other', check([row(1), grip(1), bad(2, 'no', { file: 'grip' })]), programs);
    expect(kinds(told)).toEqual({ 1: 'fine', 2: 'refused' });
  });

  it('that have a mistake are a mistake of every row that calls them', () => {
    const complaint: CheckRow = { line: 1, column: 1, file: 'grip', verdict: 'refused', sentence: 'unknown step' };
    const told = judgeRows(text, { fine: false, rows: [complaint] }, programs);
    expect(kinds(told)).toEqual({ 1: 'refused', 2: 'unchecked', 3: 'refused', 4: 'refused' });
    expect(told[1]!.why).toEqual({ sentence: 'unknown step', data: null, file: 'grip', line: 1 });
  });
});

describe('a program that cannot be planned', () => {
  const complaint = (line: number, sentence: string, more: Partial<CheckRow> = {}): CheckRow => ({
    line,
    column: 3,
    verdict: 'refused',
    sentence,
    ...more,
  });

  it('has a complaint a row where its text is wrong, and nothing is checked', () => {
    const unreadable: CheckJson = { fine: false, rows: [complaint(2, "unknown step 'jmp'"), complaint(4, 'no unit')] };
    const text = 'wait 1s\njmp\n\nwait 3\n';
    const told = judged(text, unreadable, {}, none);
    expect(told).toMatchObject({ kind: 'refused', line: 2, more: 1, why: { sentence: "unknown step 'jmp'" } });
    expect(judgeRows(text, unreadable, {})).toMatchObject({
      1: { verdict: 'unchecked', because: 'text' },
      2: { verdict: 'refused' },
      4: { verdict: 'refused' },
    });
  });

  it('says in the page’s own words which points and programs are not there', () => {
    const missing = [{ line: 1, what: 'point' as const, name: 'nowhere' }];
    const check: CheckJson = { fine: false, rows: [complaint(1, "'nowhere': no such point")] };
    const told = judged('joint to=nowhere', check, {}, { missing, open: [] });
    expect(told).toMatchObject({ kind: 'refused', line: 1, why: { missing: { name: 'nowhere' } } });
  });

  it('says so where no row of its own is to blame', () => {
    const refusal = { code: 'program_too_long', sentence: 'too long' };
    const long = judged('wait 1s', check([row(1)], { fine: false, broken_off: { sentence: 'too long', refusal } }), {}, none);
    expect(long).toMatchObject({ kind: 'refused', line: null, more: 0, why: { sentence: 'too long', data: refusal } });
    const wrong: CheckJson = { fine: false, rows: [complaint(7, 'no such key', { file: 'points.toml' })] };
    const points = judged('wait 1s', wrong, {}, none);
    expect(points).toMatchObject({ kind: 'refused', line: null, why: { sentence: 'no such key', file: 'points.toml', line: 7 } });
  });

  it('has rows that were not reached', () => {
    const told = judgeRows('wait 1s\nwait 2s', check([row(1)], { fine: false, broken_off: { sentence: 'too long' } }), {});
    expect(told[2]).toEqual({ verdict: 'unchecked', because: 'end' });
  });
});

describe('a preview that is refused', () => {
  it('names the row that was expanded into the one that it tells', () => {
    const expanded = { text: '', lines: [1, 2, 2, 3], missing: [], open: [] };
    const told = refusal('no', { code: 'joint_limit', sentence: 'no', line: 3 }, expanded);
    expect(told).toMatchObject({ line: 2, why: { sentence: 'no', data: { code: 'joint_limit' } } });
    expect(refusal('no', null, expanded)).toMatchObject({ line: null });
  });
});
