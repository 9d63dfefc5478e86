/** What a robot is set to beside its cell's file, as fields that people fill in. */
import { parseQuantity, shown } from './units';

export type Settings = Record<string, string>;

export interface SettingsJson {
  robot: string;
  file: string;
  revision: number;
  /** Something is set beside the cell's file. */
  is_set: boolean;
  own: Settings;
  now: Settings;
  running: Settings;
  restart: boolean;
  settable: string[];
  wires: string[];
  profiles: string[];
  /** Of commissioning. */
  found?: Settings;
}
export interface SettingComplaint {
  name: string;
  sentence: string;
}
export interface SettingsVerdict {
  fine: boolean;
  complaints: SettingComplaint[];
  profiles: string[];
}

export const kSimulated = 'simulated';
const kOfPlace = ['port', 'profile', 'wire'];

/** Joints of which something can be set, with what. */
export function jointsOf(settable: readonly string[]): { joint: string; can: string[] }[] {
  const joints = new Map<string, string[]>();
  for (const name of settable) {
    const match = /^joint\.(.+)\.([a-z_]+)$/.exec(name);
    if (match) joints.set(match[1]!, [...(joints.get(match[1]!) ?? []), match[2]!]);
  }
  return [...joints].map(([joint, can]) => ({ joint, can }));
}

/** With this setting, or without it where it says nothing. */
export function withSetting(all: Settings, name: string, value: string | null): Settings {
  const { [name]: _, ...rest } = all;
  return value === null ? rest : { ...rest, [name]: value };
}

/** Degrees as they are typed; what is no number is left for the controller to refuse, at its place. */
export function trimOf(typed: string): string | null {
  if (typed.trim() === '') return null;
  const value = parseQuantity(typed, 'angle');
  if (value === 0) return null;
  return value === null ? typed : String(Number(value.toPrecision(9)));
}
export function trimText(value: string | undefined): string {
  if (value === undefined) return '';
  const number = Number(value);
  return Number.isFinite(number) ? shown(number, 'angle', 2) : value;
}

/** What of the device is set at one place is so at the other: order counts for nothing. */
export function sameSettings(a: Settings, b: Settings): boolean {
  const names = new Set([...Object.keys(a), ...Object.keys(b)]);
  return [...names].every((name) => a[name] === b[name]);
}

/** The device's from commissioning, the rest as it is. */
export function withFound(all: Settings, found: Settings): Settings {
  return { ...Object.fromEntries(Object.entries(all).filter(([name]) => kOfPlace.includes(name))), ...found };
}

/** All that is set, for people. */
export const settingsText = (settings: Settings): string =>
  Object.entries(settings)
    .map(([name, value]) => `${name} ${value}`)
    .join(', ') || '–';
