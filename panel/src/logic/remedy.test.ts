import { describe, expect, it } from 'vitest';
import { kLanguages } from '../i18n';
import { remedyOf } from './remedy';
import { source } from './source.fixture';

/** Errors that bring a machine to rest: those of the server's table with a category. */
const latching = [...source('src/sinew/core/error.cc').matchAll(/\{k[A-Z]\w*, "(\w+)",([\s\S]*?)\d+\},\n/g)]
  .filter(([, , row]) => /\bkHold\b|StopCategory::kStopThenPowerOff/.test(row!))
  .map((one) => one[1]!);
const causes = [...source('docs/control.md').split('## Stops')[1]!.split('\n## ')[0]!.matchAll(/^\| \*(\w+)\* \|/gm)].map((one) => one[1]!);

describe('what to do', () => {
  it('is held against the server’s own lists', () => {
    expect(latching.length).toBeGreaterThan(30);
    expect(latching).toContain('emergency_stop');
    expect(latching).not.toContain('joint_limit');
    expect(causes).toHaveLength(11);
  });

  for (const [language, { texts }] of Object.entries(kLanguages)) {
    const said = texts as Record<string, string>;
    it(`is said of every fault in ${language}`, () => {
      for (const code of latching) {
        const remedy = remedyOf({ code });
        expect(remedy?.todo, code).toBe(`fault.${code}.do`);
        for (const key of [remedy!.means, remedy!.todo]) expect(said[key]?.trim(), key).toBeTruthy();
      }
    });
    it(`is said of every cause of a stop in ${language}`, () => {
      for (const cause of causes) {
        const remedy = remedyOf({ cause });
        expect(remedy?.todo, cause).toBe(`cause.${cause}.do`);
        for (const key of [remedy!.means, remedy!.todo]) expect(said[key]?.trim(), key).toBeTruthy();
      }
    });
  }

  it('comes from the error before it comes from the cause, and is not made up', () => {
    expect(remedyOf({ code: 'stalled', cause: 'device' })?.todo).toBe('fault.stalled.do');
    expect(remedyOf({ code: 'some_new_one', cause: 'device' })?.todo).toBe('cause.device.do');
    expect(remedyOf({ code: 'joint_limit' })).toBeNull();
    expect(remedyOf({})).toBeNull();
  });
});
