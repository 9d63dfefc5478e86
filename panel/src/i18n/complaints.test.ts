import { afterEach, describe, expect, it } from 'vitest';
import { complaintSentence, language, refusalSentence } from '.';
import { complaintsDe } from './complaints_de';
import { source } from '../logic/source.fixture';

/** Where the server reads texts. */
const kFiles = [
  'toml/findings.cc',
  'config/points_file.cc',
  'toml/toml_guard.cc',
  'core/quantity.cc',
  'model/joint_lookup.cc',
  'program/language/basket_rows.cc',
  'program/language/conditions.cc',
  'program/formats/gcode_file.cc',
  'program/language/motion_rows.cc',
  'program/language/named_points.cc',
  'program/formats/pose_file.cc',
  'program/language/program_file.cc',
  'program/formats/program_format.cc',
  'program/language/program_part.cc',
  'program/language/program_rows.h',
  'program/language/row_reader.cc',
  'devices/bigrobotarm/bigrobotarm_format.cc',
  'devices/bigrobotarm/bigrobotarm_sequence.cc',
  'program/formats/text_forms.cc',
  'server/api/api_files.cc',
];
/** What takes a message as its last argument .. */
const kTakers = /(\w+(?:\.|->))?\b(complain|complain_in|complaint_at|wrong|none|no_form|cannot|std::unexpected)\(/g;
/** .. and what gives one back, or holds one. */
const kGivers = ['unknown_row', 'unknown_subject', 'is_none', 'misfit_of_joints'];
const kHeld = /\bmessage = ("(?:[^"\\\n]|\\.)*");/g;
/** Whatever is complained of through a file's own function begins so. */
const kBegins: Record<string, Record<string, string>> = {
  'program/formats/gcode_file.cc': { complain: 'in_quotes(word) + " "' },
  'program/language/named_points.cc': { complain: 'in_quotes(name)' },
  'program/formats/pose_file.cc': { wrong: 'in_quotes(word)' },
  'program/language/program_part.cc': { 'std::unexpected': '"from_line: "' },
};
/** Parts of messages that are words: what a call has as an argument, what a function or a table gives, an expression. */
type Means = { call: string; place: number; of?: string } | { gives: string } | { table: string; of: string } | string;
const kTypes: Means = { table: 'kNames', of: 'toml/toml_tree.cc' };
const kMeans: Record<string, Record<string, readonly Means[]>> = {
  'config/points_file.cc': { 'type_name(entry->node)': [kTypes], 'type_name(node)': [kTypes] },
  'program/language/conditions.cc': { all: ['" " + names'] },
  'program/formats/gcode_file.cc': { what: [{ call: 'needs_amount', place: 0 }] },
  'program/language/motion_rows.cc': { what: [{ call: 'unknown', place: 2 }] },
  'program/language/named_points.cc': { all: ['" " + names'] },
  'program/formats/pose_file.cc': { what: [{ call: 'has_rows', place: 2 }] },
  'program/language/program_part.cc': { name: ['"line " + number'] },
  'program/language/row_reader.cc': { example: [{ call: 'takes_words', place: 1, of: 'program/language/program_file.cc' }] },
  'devices/bigrobotarm/bigrobotarm_sequence.cc': {
    what: [{ call: 'take_number', place: 3 }, { call: 'take_words', place: 2 }],
    'suggestion(name)': [{ gives: 'suggestion' }],
  },
};
/**
 * Messages that are made elsewhere in these files. What others make stays English: what the TOML parser says of a text
 * that is none (toml_tree.cc), and what a disk says of a program that is called (Keeper::kept_program).
 */
const kHandedOn = [
  '*why', // unknown_row()
  'body.error()', // Reading::called()
  'in_quotes(code.word.text) + " " + std::move(message)',
  'in_quotes(point.name) + why',
  'in_quotes(word.substr(0, 40)) + why',
  'message',
  'misfit', // misfit_of_joints()
  'std::move(message)',
  'unknown_row(name).value_or("unknown step")',
  'unknown_subject(name, robot)',
  'value.error()', // parse_quantity()
];
/** Strings that nobody complains with. */
const kNoMessages = [
  // Notes beside the rows of a sequence.
  ' cannot be sent on this wire; ',
  "without S1 each joint of the arm's own firmware arrives in its own time; here the ",
  'joints arrive together',
  ' of the robot\'s file: no board has shown it',
  ', more than the ',
  '# heads fit the platform to ',
  ' mm; totals of moves ',
  ' mm, of turns ',
  'form is sequence, pos or gcode', // of the page itself
  'form is sequence or pos',
];

const kString = /"(?:[^"\\\n]|\\.)*"/;
/** Strings, characters and `::` are of one piece. */
const kPiece = new RegExp(`${kString.source}|'(?:[^'\\\\\\n]|\\\\.)'|::|[^]`, 'g');
const code = (file: string): string =>
  source(`src/sinew/${file}`).replace(new RegExp(`(${kString.source}|'(?:[^'\\\\\\n]|\\\\.)')|//[^\\n]*`, 'g'), '$1');
const squeezed = (text: string): string => text.replace(/\s+/g, ' ').trim();

/** What stands in the brackets that were opened before `begin`. */
function inside(text: string, begin: number): string {
  let depth = 1;
  let end = begin;
  for (const [one] of text.slice(begin).matchAll(kPiece)) {
    if ('([{'.includes(one)) ++depth;
    if (')]}'.includes(one) && --depth === 0) break;
    end += one.length;
  }
  return text.slice(begin, end);
}

/** The parts of an expression between separators that stand in no brackets. */
function split(text: string, separator: string): string[] {
  const parts = [''];
  let depth = 0;
  for (const [one] of text.matchAll(kPiece)) {
    if ('([{'.includes(one)) ++depth;
    if (')]}'.includes(one)) --depth;
    if (depth === 0 && one === separator) parts.push('');
    else parts[parts.length - 1] += one;
  }
  return parts.map((part) => part.trim());
}

const literal = (text: string): string =>
  [...text.matchAll(new RegExp(kString, 'g'))].map(([one]) => one.slice(1, -1).replace(/\\(.)/g, '$1')).join('');

/** Everything that an expression can say, with {..} for what only a run knows. */
function said(expression: string, means: Readonly<Record<string, string[]>>): string[] {
  const text = expression.trim();
  const choice = split(text, '?');
  if (choice.length > 1) {
    const [one, ...others] = split(choice.slice(1).join(' ? '), ':');
    return [one!, others.join(' : ')].flatMap((way) => said(way, means));
  }
  const sum = split(text, '+');
  if (sum.length > 1) {
    return sum.map((one) => said(one, means)).reduce((all, one) => all.flatMap((begin) => one.map((end) => begin + end)));
  }
  if (means[text]) return means[text].flatMap((one) => said(one, means));
  if (new RegExp(`^(?:${kString.source}\\s*)+$`).test(text)) return [literal(text)];
  const wrapped = /^(?:std::string|std::move)?\(/.exec(text);
  if (wrapped) return said(inside(text, wrapped[0].length), means);
  const list = /^std::vector<Complaint>\{\s*\{/.exec(text);
  if (list) return said(split(inside(text, list[0].length), ',').at(-1)!, means);
  return [text.startsWith('in_quotes(') ? "'{..}'" : '{..}'];
}

function returnsOf(text: string, name: string): string[] {
  const begin = new RegExp(`\\b${name}\\([^)]*\\)(?: const)? \\{`).exec(text);
  if (!begin) return [];
  const body = inside(text, begin.index + begin[0].length);
  return [...body.matchAll(new RegExp(`\\breturn ((?:${kString.source}|[^";])+);`, 'g'))].map((one) => one[1]!);
}

function expressionsOf(means: Means, file: string): string[] {
  if (typeof means === 'string') return [means];
  const text = code(('of' in means && means.of) || file);
  if ('gives' in means) return returnsOf(text, means.gives);
  if ('table' in means) {
    const begin = text.indexOf(`${means.table}[] = {`) + `${means.table}[] = {`.length;
    return split(inside(text, begin), ',');
  }
  return [...text.matchAll(new RegExp(`\\b${means.call}\\(`, 'g'))]
    .map((one) => split(inside(text, one.index + one[0].length), ',')[means.place] ?? '')
    .filter((one) => one.startsWith('"'));
}

interface Message {
  expression: string;
  taker: string;
  texts: string[];
}

function messagesIn(file: string): Message[] {
  const text = code(file);
  const means = Object.fromEntries(
    Object.entries(kMeans[file] ?? {}).map(([name, all]) => [name, all.flatMap((one) => expressionsOf(one, file))]),
  );
  const taken = [...text.matchAll(kTakers)].flatMap(([whole, whose = '', taker], i, all) => {
    const args = split(inside(text, all[i]!.index + whole.length), ',');
    const expression = squeezed(args.at(-1)!);
    // Where the function itself is written.
    if (/^(?:const )?(?:std::)?[\w<>]+&? (?!\+)\w+$/.test(expression)) return [];
    const begin = whose ? undefined : kBegins[file]?.[taker!];
    return [{ expression, taker: taker!, texts: said(begin ? `${begin} + (${expression})` : expression, means) }];
  });
  const given = kGivers.flatMap((name) => returnsOf(text, name));
  const held = [...text.matchAll(kHeld)].map((one) => one[1]!);
  return [...taken, ...[...given, ...held].map((expression) => ({ expression, taker: '', texts: said(expression, means) }))];
}

const speaks = (text: string): boolean => /[a-z]{2}/i.test(text);
const all = kFiles.flatMap(messagesIn);
const english = [...new Set(all.flatMap((one) => one.texts).filter(speaks))];

/** As a run fills it in. */
function filledIn(text: string): { sentence: string; values: string[] } {
  const values: string[] = [];
  const sentence = text.replace(/\{\.\.\}/g, () => values[values.push(`v${values.length}v`) - 1]!);
  return { sentence, values };
}

afterEach(() => {
  language.value = 'en';
});

describe('the messages of the server', () => {
  it('were found', () => {
    expect(english.length).toBeGreaterThan(180);
    for (const one of [
      "'{..}' needs a unit: {..}",
      "unknown step '{..}'; did you mean {..}?",
      "'{..}' is no taught point; there are {..} and more",
      "'{..}' means the zero of a workpiece; here zero is the robot's base",
      "'{..}' needs S, the degrees of the gripper",
      "'{..}': the gripper's switch must be {..}..{..}",
      "unknown command '{..}': commands are G0 G28 G92 M203 M201 G1 S0 S1 BEGIN END",
      'from_line: line {..} is inside the loop of line {..}: begin there, or behind its end',
      'must be a string, not a whole number',
      'too many complaints; mend these first',
    ]) {
      expect(english).toContain(one);
    }
  });

  it('are made here, or handed on from here', () => {
    const mute = all.filter((one) => one.taker.startsWith('complain') && !one.texts.some(speaks));
    expect([...new Set(mute.map((one) => one.expression))].sort()).toEqual(kHandedOn);
    expect(code('server/api/api_methods.cc')).toContain('invalid("from_line: " + part.error())');
  });

  for (const file of kFiles) {
    it(`are all of the sentences in ${file}`, () => {
      for (const [one] of code(file).matchAll(new RegExp(kString, 'g'))) {
        const part = literal(one);
        if (part.split(' ').filter((word) => /^[a-z]+[,;:]?$/.test(word)).length < 3) continue;
        const known = english.some((text) => text.includes(part)) || kNoMessages.includes(one.slice(1, -1));
        expect(known, part).toBe(true);
      }
    });
  }

  for (const text of english) {
    it(`has a German one: ${text}`, () => {
      const { sentence, values } = filledIn(text);
      expect(complaintSentence(sentence)).toBe(sentence);
      language.value = 'de';
      const german = complaintSentence(sentence);
      expect(german).not.toBe(sentence);
      for (const value of values) expect(german).toContain(value);
      expect(german).not.toMatch(/\b(the|which|of|and|or|has|is|are|write|needs|calls|a)\b/);
      expect(german).not.toMatch(/[{}]/);
    });
  }
});

describe('the German messages', () => {
  const texts = english.map((text) => filledIn(text).sentence);
  const holes = (text: string): string[] => [...text.matchAll(/\{(\w+)\}/g)].map((one) => one[1]!).sort();
  const fits = (template: string): RegExp =>
    new RegExp(template.replace(/[.*+?^$()|[\]\\]/g, '\\$&').replace('{word}', "'.*?'").replace(/\{\w+\}/g, '.+?'));

  it('answer to one that is said', () => {
    for (const one of Object.keys(complaintsDe.sentences)) {
      const whole = new RegExp(`^${fits(one).source}(?:[;:] .+)?$`);
      expect(texts.some((text) => whole.test(text)), one).toBe(true);
    }
    for (const one of Object.keys(complaintsDe.endings)) {
      const ending = new RegExp(`[;:] ${fits(one).source}$`);
      expect(texts.some((text) => ending.test(text)), one).toBe(true);
    }
  });

  it('have the same holes to fill', () => {
    for (const [one, german] of Object.entries({ ...complaintsDe.sentences, ...complaintsDe.endings })) {
      expect(holes(german), one).toEqual(holes(one));
      expect(german.trim(), one).not.toBe('');
    }
  });

  it('keep what was written, whatever that is', () => {
    language.value = 'de';
    expect(complaintSentence("unknown step 'wiat'; did you mean wait?")).toBe("Unbekannter Schritt 'wiat'; ist wait gemeint?");
    expect(complaintSentence("unknown step ''; steps are joint move")).toBe("Unbekannter Schritt ''; Schritte sind joint move");
    expect(complaintSentence("'3' needs a unit: mm, cm, m, in")).toBe("'3' braucht eine Einheit: mm, cm, m, in");
    expect(complaintSentence("'it's' is no joint of this robot; it has base speed")).toBe(
      "'it's' ist kein Gelenk dieses Roboters; möglich sind base speed",
    );
    expect(complaintSentence("'legs' has 5 joints, six has 6 legs")).toBe("'legs' hat 5 Gelenke, six hat 6 Beine");
    expect(complaintSentence('a program cannot call itself: a calls b calls a')).toBe(
      'Ein Programm kann sich nicht selbst aufrufen: a ruft b ruft a',
    );
    expect(complaintSentence("'$&' ends in '$1', which is none of V")).toBe("'$&' endet mit '$1', möglich sind V");
    expect(complaintSentence('something that nobody knew of')).toBe('something that nobody knew of');
  });
});

describe('a refused text', () => {
  const complaint = { file: 'the file', line: 2, column: 5, sentence: "'G54' belongs to a G4" };
  const say = (file: string, key = '', sentence = complaint.sentence): string =>
    refusalSentence({
      message: `${file}:2:5: ${key}${sentence}`,
      data: { complaints: [{ ...complaint, file, sentence }, { ...complaint, line: 9 }] },
    });

  it('is told as it came in English', () => {
    expect(say('the file')).toBe("the file:2:5: 'G54' belongs to a G4");
  });

  it('is told with its place, and whom it is about', () => {
    language.value = 'de';
    expect(say('the file')).toBe("Zeile 2: 'G54' gehört zu einem G4");
    expect(say('grip')).toBe("in grip, Zeile 2: 'G54' gehört zu einem G4");
    expect(say('points.toml', 'points.P.robot: ', 'joints_deg says that')).toBe(
      'in points.toml, Zeile 2: points.P.robot: das sagt schon joints_deg',
    );
    expect(say('points.toml', '', 'Error while parsing key')).toBe('points.toml:2:5: Error while parsing key');
  });

  it('or one without a place is told, too', () => {
    language.value = 'de';
    expect(refusalSentence({ message: "sequences are the BigRobotArm's; learm is none" })).toBe(
      'Sequenzen sind Sache des BigRobotArm; learm ist keiner',
    );
    expect(refusalSentence({ message: "'20' needs a unit: deg, rad", data: null })).toBe("'20' braucht eine Einheit: deg, rad");
  });
});
