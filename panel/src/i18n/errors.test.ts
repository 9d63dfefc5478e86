import { afterEach, describe, expect, it } from 'vitest';
import { errorSentence, kLanguages, language, refusalSentence } from '.';
import { errorsDe } from './errors_de';
import { kAskerUnknown, kOtherUnknown } from '../logic/sentence';
import { source } from '../logic/source.fixture';

const table = source('src/sinew/core/error.cc');

/** The server's own table: its codes with their English sentences. */
const english = new Map(
  [...table.matchAll(/\{k[A-Z]\w*, "(\w+)",\s*((?:"(?:[^"\\]|\\.)*"\s*)+)/g)].map(([, code, parts]) => [
    code!,
    [...parts!.matchAll(/"((?:[^"\\]|\\.)*)"/g)].map((one) => one[1]).join(''),
  ]),
);
const holes = (text: string): string[] => [...text.matchAll(/\{(\w+)\}/g)].map((one) => one[1]!);
const kept = ['conflict', 'missing', 'too_large', 'too_many', 'no_room', 'under_way', 'damaged', 'unfit', 'disk'];

afterEach(() => {
  language.value = 'en';
});

describe('the table of errors', () => {
  it('was read whole', () => {
    const rows = [...table.matchAll(/^ {4}\{k[A-Z]\w*, "\w+"/gm)].length;
    expect(rows).toBeGreaterThan(70);
    expect(english.size).toBe(rows);
    expect(english.get('supply_low')).toBe('the supply is down to {measured}, limit {limit}');
  });

  for (const [code, sentence] of english) {
    it(`${code} has a German sentence that asks for nothing else`, () => {
      const german = errorsDe.codes[code];
      expect(german?.trim(), code).toBeTruthy();
      for (const hole of holes(german!)) expect(holes(sentence), german).toContain(hole);
    });
  }

  it('has no German sentence of a code that nobody tells', () => {
    for (const code of Object.keys(errorsDe.codes)) {
      expect(english.has(code) || [...kept, 'empty', 'no_text'].includes(code), code).toBe(true);
    }
    for (const code of kept) expect(errorsDe.codes[code], code).toBeTruthy();
  });
});

describe('an error', () => {
  const limit = { code: 'joint_limit', sentence: 'elbow would need 130 deg, limit 90 deg, 40 deg too far', joint: 'elbow' };
  const numbers = { measured_rad: (130 * Math.PI) / 180, limit_rad: Math.PI / 2 };

  it('is said in the words of the server in English, filled in in German', () => {
    expect(errorSentence({ ...limit, ...numbers })).toBe(limit.sentence);
    language.value = 'de';
    expect(errorSentence({ ...limit, ...numbers })).toBe('elbow müsste auf 130°, die Grenze ist 90°: 40° zu weit');
  });

  it('of a joint whose board is left out names no homing', () => {
    language.value = 'de';
    expect(errorSentence({ code: 'position_unknown', sentence: 'x', joint: 'elbow', left_out: true })).toBe(
      'elbow ist ausgelassen, seine Position unbekannt; Gelenkbewegungen verwenden, die elbow nicht nennen',
    );
  });

  it('is English where a value is missing, is no number, or its code is new', () => {
    language.value = 'de';
    expect(errorSentence(limit)).toBe(limit.sentence);
    expect(errorSentence({ ...limit, ...numbers, ...{ limit_rad: null } } as object)).toBe(limit.sentence);
    expect(errorSentence({ ...limit, ...numbers, joint: undefined })).toBe(limit.sentence);
    expect(errorSentence({ code: 'some_new_one', sentence: 'new' })).toBe('new');
    expect(errorSentence({ sentence: 'without a code' })).toBe('without a code');
  });

  it('has its numbers in the units that people read, with as many places as tell them apart', () => {
    language.value = 'de';
    const say = (told: object) => errorSentence({ sentence: 'english', ...told });
    expect(say({ code: 'leg_length', joint: 'leg1', measured_m: 0.28004, limit_m: 0.28 })).toBe(
      'leg1 müsste 280.04 mm lang sein, die Grenze ist 280 mm: 0.04 mm zu weit',
    );
    expect(say({ code: 'moved_unasked', joint: 'leg1', measured_m: -0.01, limit_m: 0 })).toMatch(/^leg1 steht auf −10 mm .* 10 mm daneben/);
    expect(say({ code: 'cycle_overrun', measured_s: 0.0123, limit_s: 0.01 })).toMatch(/um 0\.0123 s, Grenze 0\.01 s/);
    expect(say({ code: 'supply_low', measured_v: 9.04, limit_v: 10 })).toBe('Die Versorgung ist auf 9.04 V gefallen, die Grenze ist 10 V');
    expect(say({ code: 'target_velocity', joint: 'base', measured_rad_s: Math.PI, limit_rad_s: 1 })).toMatch(/mit 180°\/s .* 57\.3°\/s/);
    expect(say({ code: 'step_range', joint: 'base', measured: 123456, limit: 99999 })).toBe('base bräuchte Schritt 123456, die Grenze ist 99999');
    expect(say({ code: 'jump', joint: 'base', measured: 1.23456, limit: 1 })).toMatch(/um das 1\.23-Fache/);
    expect(say({ code: 'collision', links: 'forearm and table', measured_m: 0.002, limit_m: 0.005 })).toBe(
      'forearm und table kämen sich bis auf 2 mm nahe, verlangt sind mindestens 5 mm',
    );
  });

  it('tells an overlap as one, and how far to back off', () => {
    language.value = 'de';
    const say = (told: object) => errorSentence({ sentence: 'english', links: 'tool and table', ...told });
    expect(say({ code: 'collision', measured_m: -0.1718, limit_m: 0.005 })).toBe(
      'tool und table würden sich um 171.8 mm überschneiden; nötiger Abstand 5 mm',
    );
    expect(say({ code: 'jaws_contact', measured_m: 0, limit_m: 0.03 })).toMatch(/30 mm weiter vor.* dz=-30mm$/);
  });

  it('names the board where there are several', () => {
    language.value = 'de';
    const silent = { code: 'device_silent', sentence: 'english', measured_s: 0.2, limit_s: 0.05 };
    expect(errorSentence(silent)).toBe('Das Gerät hat nicht innerhalb von 0.05 s geantwortet');
    expect(errorSentence({ ...silent, joint: 'wrist' })).toMatch(/^Die Platine von wrist /);
  });

  it('of a refused answer comes from its data, and a stop says whose', () => {
    language.value = 'de';
    const message = 'the disk is full';
    expect(refusalSentence({ message, data: { code: 'disk' } })).toContain('(the disk is full)');
    expect(refusalSentence({ message, data: { code: 'too_many' } })).toMatch(/höchstens 200/);
    expect(refusalSentence({ message, data: null })).toBe(message);
    expect(refusalSentence({ message: 'stopped: client', data: { cause: 'client' } })).toBe('gestoppt: durch Bedienung');
  });
});

describe('what is in the way in a cell', () => {
  const met = {
    code: 'cell_contact',
    sentence: 'forearm would come within 3 mm of max (hand) at 40 % of the way (120 mm), at least 20 mm is asked for: ..',
    link: 'forearm',
    other: 'max',
    other_link: 'hand',
    share: 0.4,
    way_m: 0.12,
    distance_m: 0.003,
    margin_m: 0.02,
    moving: false,
  };
  const say = (more: object) => {
    language.value = 'de';
    return errorSentence({ ...met, ...more });
  };

  it('is told with its place and what helps', () => {
    expect(say({})).toBe(
      'forearm käme max (hand) bis auf 3 mm nahe, bei 40 % des Weges (120 mm); verlangt sind mindestens 20 mm. max wegbewegen oder einen anderen Weg nehmen.',
    );
    expect(say({ code: 'cell_taken', moving: true })).toMatch(/Warten, bis max weg ist/);
    expect(say({ other: 'box', other_link: undefined })).toMatch(/^forearm käme box bis .*\. Einen anderen Weg nehmen\.$/);
    expect(say({ distance_m: -0.003 })).toMatch(/^forearm würde max \(hand\) um 3 mm überschneiden, bei 40 %/);
    expect(say({ share: 0, distance_m: undefined })).toMatch(/^forearm käme max \(hand\) zu nahe, schon am Anfang;/);
  });

  it('is told otherwise where nobody knows where one of them is, as the server does', () => {
    for (const part of [kAskerUnknown, kOtherUnknown]) {
      expect(source('src/sinew/runtime/cell_space.cc').replaceAll(/"\s+"/g, ''), part).toContain(part);
    }
    expect(say({ sentence: `${kAskerUnknown} or goes` })).toMatch(/^Niemand weiß, wo dieser Roboter steht/);
    expect(say({ sentence: `forearm may come to max, and ${kOtherUnknown}: home it` })).toMatch(/^forearm käme vielleicht an max \(hand\)/);
  });

  it('is English where a part is missing, and general where only its numbers are told', () => {
    expect(say({ margin_m: undefined })).toBe(met.sentence);
    expect(say({ other: undefined, measured_m: 0.003, limit_m: 0.02 })).toMatch(/^forearm käme etwas anderem in der Zelle bis auf 3 mm nahe/);
  });

  it('has each of its parts filled in, in every language that has one', () => {
    for (const words of Object.values(kLanguages)) {
      if (!('errors' in words)) continue;
      for (const part of Object.values(words.errors.inCell)) expect(part.trim()).not.toBe('');
    }
  });
});
