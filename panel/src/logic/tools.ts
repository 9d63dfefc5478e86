import { wordsOf } from './row_kinds';
import type { RobotModel } from './types';
import { toDeg, toRad } from './units';

type ToolWord = 'jaws' | 'gripper' | 'suction' | 'nozzle';
export type ToolChoice = 'open' | 'close' | 'on' | 'release' | 'off';

/** What a robot's tool can be told, as rows of a program. */
export interface Tool {
  word: ToolWord;
  row: (argument: string) => string;
  choices: readonly { id: ToolChoice; argument: string }[];
  /** A number that it takes, SI, and the argument that says it. */
  amount?: {
    measure: 'length' | 'angle';
    initial: number;
    text: (value: number) => string;
    /** Of an argument that was sent; nothing where it is no number. */
    of: (argument: string | undefined) => number | undefined;
  };
  /** SI, of a device that tells it. */
  measured?: (health: Readonly<Record<string, number>>) => number | undefined;
}

const numberOf = (argument: string | undefined, unit: string, scale: (value: number) => number): number | undefined =>
  argument?.endsWith(unit) ? scale(parseFloat(argument)) : undefined;
const degrees = {
  measure: 'angle',
  text: (value: number) => `${toDeg(value).toFixed(1)}deg`,
  of: (argument: string | undefined) => numberOf(argument, 'deg', toRad),
} as const;

export function toolsOf(model: RobotModel): Tool[] {
  const width = model.kind === 'serial' ? (model.geometry.gripper?.width_max_m ?? 0) : 0;
  const mm = (value: number) => `${(1000 * Math.min(Math.max(value, 0), width)).toFixed(1)}mm`;
  const all: Record<ToolWord, Tool> = {
    jaws: {
      word: 'jaws',
      row: (argument) => `jaws ${argument}`,
      choices: [
        { id: 'open', argument: mm(width) },
        { id: 'close', argument: mm(0) },
      ],
      amount: { measure: 'length', initial: width, text: mm, of: (argument) => numberOf(argument, 'mm', (value) => value / 1000) },
      measured: (health) => health.jaws_width_m,
    },
    gripper: {
      word: 'gripper',
      row: (argument) => `gripper ${argument}`,
      choices: [
        { id: 'on', argument: 'on' },
        { id: 'off', argument: 'off' },
      ],
      amount: { ...degrees, initial: 0 },
    },
    suction: {
      word: 'suction',
      row: (argument) => `suction ${argument}`,
      choices: (['on', 'release', 'off'] as const).map((id) => ({ id, argument: id })),
    },
    nozzle: {
      word: 'nozzle',
      row: (argument) => `nozzle ${argument} time=1s`,
      choices: [],
      amount: { ...degrees, initial: Math.PI / 2 },
    },
  };
  const words: readonly string[] = wordsOf(model);
  return Object.values(all).filter((tool) => words.includes(tool.word));
}
