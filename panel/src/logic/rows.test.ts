import { describe, expect, it } from 'vitest';
import {
  copyRow,
  insertRows,
  lastOf,
  moveRow,
  readRows,
  readSlot,
  removeRow,
  replaceLine,
  stepRow,
  writeSlot,
} from './rows';

const kText = `# A wave.
joint base=0deg
loop 2
  joint base=30deg  # there
  if x>1mm
    jaws 10mm
  else
    wait 1s
  end
end
joint base=0deg
`;

describe('rows', () => {
  it('know their depth and where their block ends', () => {
    const { rows, whole } = readRows(kText);
    expect(whole).toBe(true);
    expect(rows.map((one) => one.depth)).toEqual([0, 0, 0, 1, 1, 2, 1, 2, 1, 0, 0, 0]);
    expect(rows[2]!.end).toBe(10);
    expect(rows[4]!.end).toBe(9);
    expect(rows[3]!.tokens).toEqual(['joint', 'base=30deg']);
    expect(rows[3]!.remark).toBe('# there');
    expect(lastOf(readRows(kText), 3)).toBe(10);
  });

  it('say where a block has no end, or an end no block', () => {
    expect(readRows('loop 2\nwait 1s').whole).toBe(false);
    expect(readRows('end').whole).toBe(false);
    expect(readRows('loop 2\nelse\nend').whole).toBe(false);
  });

  it('move with their whole block and take their depth from where they come to stand', () => {
    const change = moveRow(kText, 2, 5)!;
    expect(change.line).toBe(4);
    expect(change.text.split('\n')[3]).toBe('  joint base=0deg');
    const block = moveRow(kText, 5, 3)!;
    expect(block.text.split('\n').slice(2, 7)).toEqual(['if x>1mm', '  jaws 10mm', 'else', '  wait 1s', 'end']);
    expect(readRows(block.text).whole).toBe(true);
  });

  it('do not move where blocks would break, nor into themselves', () => {
    expect(moveRow(kText, 10, 2)).toBeNull();
    expect(moveRow(kText, 3, 6)).toBeNull();
    expect(moveRow(kText, 7, 2)).toBeNull();
  });

  it('step over a neighbour, into a block and out of it', () => {
    expect(stepRow('wait 1s\nwait 2s\n', 2, -1)).toEqual({ text: 'wait 2s\nwait 1s\n', line: 1 });
    expect(stepRow('wait 1s\nwait 2s\n', 1, -1)).toBeNull();
    expect(stepRow('wait 1s\nwait 2s\n', 2, 1)).toBeNull();
    const into = stepRow('wait 1s\nloop 2\n  wait 2s\nend\n', 1, 1)!;
    expect(into.text).toBe('loop 2\n  wait 1s\n  wait 2s\nend\n');
    expect(stepRow(into.text, 2, -1)!.text).toBe('wait 1s\nloop 2\n  wait 2s\nend\n');
  });

  it('are inserted as deep as they stand, and before the last empty line', () => {
    const inside = insertRows('loop 2\n  wait 1s\nend\n', 2, ['wait 2s']);
    expect(inside.text).toBe('loop 2\n  wait 1s\n  wait 2s\nend\n');
    expect(insertRows('', 0, ['wait 1s']).text).toBe('wait 1s\n');
    expect(insertRows('wait 1s\n', 9, ['loop 2', 'end']).text).toBe('wait 1s\nloop 2\nend\n');
  });

  it('go and are copied with all of their block', () => {
    expect(removeRow(kText, 3)).toBe('# A wave.\njoint base=0deg\njoint base=0deg\n');
    expect(copyRow('loop 2\n  wait 1s\nend\n', 1).text).toBe('loop 2\n  wait 1s\nend\nloop 2\n  wait 1s\nend\n');
  });

  it('change one word and leave the others and the remark as they stand', () => {
    const raw = '  line x=1mm speed=50% speed=80mm/s  # slow';
    const share = { key: 'speed', unit: /%$/ };
    const tool = { key: 'speed', unit: /\/s$/ };
    const tokens = raw.trim().split(' ');
    expect(readSlot(tokens, share)).toBe('50%');
    expect(readSlot(tokens, tool)).toBe('80mm/s');
    expect(writeSlot(raw, share, '20%')).toBe('  line x=1mm speed=20% speed=80mm/s  # slow');
    expect(writeSlot(raw, tool, '')).toBe('  line x=1mm speed=50%  # slow');
    expect(writeSlot(raw, { key: 'y' }, '2mm')).toBe('  line x=1mm speed=50% speed=80mm/s y=2mm  # slow');
    expect(writeSlot('jaws 10mm', { at: 1 }, '20mm')).toBe('jaws 20mm');
    expect(replaceLine('a\nb\nc', 2, 'x')).toBe('a\nx\nc');
  });
});
