/** What a robot's device tells of itself, as docs/api.md has it, and as tables that people read. */
import type { ErrorJson } from './types';
import { decimals, duration, toDeg } from './units';

export interface DeviceWarning {
  name: string;
  joint?: string;
  age_s?: number;
}

export interface Heard {
  age_s?: number;
  bytes?: string;
}

export interface LegJson extends Heard {
  joint: string;
  motion?: string;
  temperature?: string;
  flags?: string[];
  actual_units?: number;
  target_units?: number;
  run_current_ma?: number;
  hold_current_ma?: number;
  velocity_max_steps_s?: number;
  velocity_min_steps_s?: number;
  acceleration_steps_s2?: number;
  microsteps?: number;
  secure_position?: number;
  address?: number;
  switch_closed?: boolean;
  last_trouble?: Heard & { flags: string[] };
}

export interface ServoJson {
  servo?: number;
  joint?: string;
  units?: number;
  pulse?: number;
  position_rad?: number;
}

export interface GroupJson extends Heard {
  group?: number;
  times?: number;
}

export interface RegisterJson extends Heard {
  register: string;
  written: boolean;
  value?: number;
  position_rad?: number;
  fault_number?: number;
}

export interface AxisJson extends Heard {
  joint: string;
  answers: boolean;
  fault?: ErrorJson;
  flags?: Record<string, boolean>;
  registers?: RegisterJson[];
  position_rad?: number;
  velocity_rad_s?: number;
  setpoint_rad?: number;
  following_error_rad?: number;
  position_units?: number;
  fault_number?: number;
  verdict?: string;
  failed_frames?: number;
  late_frames?: number;
  identity?: Heard & { model_hash: number; boot: number; uncertainty_rad: number };
  health?: Heard & { supply_v?: number; temperature_c?: number; motor_magnet?: Magnet; joint_magnet?: Magnet };
  zero_shift_rad?: number;
}

/** What an AS5600 reports of its magnet. */
export type Magnet = 'good' | 'too weak' | 'too strong' | 'missing' | 'no reply';

/** One servo of a bus that the host speaks to itself. */
export interface BusServoJson extends Heard {
  joint: string;
  servo: number;
  answers: boolean;
  model?: number;
  firmware?: string;
  motor_on?: boolean;
  units?: number;
  goal_units?: number;
  lowest_units?: number;
  highest_units?: number;
  load?: number;
  torque_limit?: number;
  volts?: number;
  temperature_c?: number;
  temperature_max_c?: number;
  position_rad?: number;
  /** Between jaws. */
  width_m?: number;
}

/** What a board's inputs show; all but `state` and `end_stops` are closed where they are true. */
export interface InputsJson extends Heard {
  state: string;
  probe: boolean;
  door: boolean;
  hold: boolean;
  reset: boolean;
  start: boolean;
  emergency_stop: boolean;
  end_stops: string[];
}

export interface DeviceJson {
  robot: string;
  port: string;
  wire: string;
  at_s: number;
  warnings: DeviceWarning[];
  legs?: LegJson[];
  board?: string;
  unit?: 'us' | 'bus';
  battery?: Heard & { volts: number; notice_below_volts: number; fault_below_volts: number };
  version?: Heard & { type: number; version: number };
  told?: Heard & { time_ms: number; servos: ServoJson[] };
  positions?: Heard & { measured: boolean; servos: ServoJson[] };
  group_started?: GroupJson;
  group_finished?: GroupJson;
  group_stopped?: GroupJson;
  checksum?: string;
  angles?: Heard & { servos: ServoJson[] };
  position?: Heard & { xyz_mm: number[] };
  spoken?: string;
  wants_declaration?: boolean;
  looks_like_boot?: boolean;
  status?: Heard & {
    joints: { joint: string; steps: number; speed_rev_s: number; acceleration_rev_s2: number }[];
    gripper?: { enabled: boolean; servo_deg: number };
    sync: boolean;
  };
  arm?: Heard & {
    session: number;
    moving: boolean;
    stop_line: boolean;
    fault: string;
    reference: string;
    queued_ms: number;
    gripper: { enabled: boolean; servo_deg: number };
    joints: { joint: string; steps: number }[];
  };
  image?: Heard & { board: string; version: string; checksum: number };
  statistics?: Heard & {
    starts: number;
    stack_free_bytes: number;
    late_slices: number;
    loop_us_max: number;
    bytes_lost: number;
    frames_bad: number;
  };
  axes?: AxisJson[];
  bus_servos?: BusServoJson[];
  firmware?: string;
  inputs?: InputsJson;
  touched?: Heard & { joint: string; position_rad?: number; position_m?: number };
  reports_status?: boolean;
  round_s?: number;
}

/** Some things are so and want to be known; nothing is wrong with the machine. */
const kNotices = new Set(['not_homed', 'wants_declaration', 'end_stop']);

export interface Warned {
  name: string;
  joints: string[];
  /** s since it was told last, where it may be over. */
  age?: number;
  grave: boolean;
}

/** Inputs that are closed besides the probe and the end stops, by name. */
export const closedInputs = (inputs: InputsJson): string[] =>
  (['door', 'hold', 'reset', 'start', 'emergency_stop'] as const).filter((one) => inputs[one]);

/** Where a joint was when the probe closed; a dash where that is not known. */
export const touchText = (touched: { position_rad?: number; position_m?: number }): string =>
  touched.position_m === undefined ? degrees(touched.position_rad, 3) : `${decimals(1000 * touched.position_m, 3)} mm`;

/** One row a thing, whichever joints have it; the grave ones first. */
export function warned(warnings: readonly DeviceWarning[]): Warned[] {
  const rows = new Map<string, Warned>();
  for (const one of warnings) {
    const row = rows.get(one.name) ?? { name: one.name, joints: [], grave: !kNotices.has(one.name) };
    if (one.joint) row.joints.push(one.joint);
    if (one.age_s !== undefined) row.age = Math.min(row.age ?? Infinity, one.age_s);
    rows.set(one.name, row);
  }
  return [...rows.values()].sort((a, b) => Number(b.grave) - Number(a.grave));
}

/** "0.1 s"; whatever is younger is as good as now. */
export const ageText = (seconds: number): string => duration(Math.max(0.1, Math.round(seconds * 10) / 10));

export const degrees = (rad: number | undefined, digits = 2): string =>
  rad === undefined ? '–' : `${decimals(toDeg(rad), digits)}°`;

/** A status of the hexapod byte by byte: what each one holds, by its place. */
export function statusBytes(leg: LegJson): { byte: string; values: [string, string | number | boolean][] }[] {
  const bytes = (leg.bytes ?? '').split(' ');
  if (bytes.length !== 12) return [];
  const flags = (leg.flags ?? []).filter((one) => !one.startsWith('over_') && one !== 'charge_pump_failure');
  const others = (leg.flags ?? []).filter((one) => !flags.includes(one));
  const values: [string, string | number | boolean][][] = [
    [['address', `0x${(leg.address ?? 0).toString(16).toUpperCase()}`]],
    [['run_current_ma', leg.run_current_ma ?? 0], ['hold_current_ma', leg.hold_current_ma ?? 0]],
    [['velocity_max', leg.velocity_max_steps_s ?? 0], ['velocity_min', Math.round(leg.velocity_min_steps_s ?? 0)]],
    [['acceleration', leg.acceleration_steps_s2 ?? 0], ['microsteps', leg.microsteps ?? 0]],
    [['flags', flags.join(' ')], ['temperature', leg.temperature ?? '']],
    [['motion', leg.motion ?? ''], ['switch', leg.switch_closed ?? false], ['flags', others.join(' ')]],
    [['actual_high', leg.actual_units ?? 0]],
    [['low', '']],
    [['target_high', leg.target_units ?? 0]],
    [['low', '']],
    [['secure_low', leg.secure_position ?? 0]],
    [['secure_high', '']],
  ];
  return bytes.map((byte, i) => ({ byte, values: values[i]! }));
}

/** Told and read beside each other, servo by servo. */
export interface ServoRow {
  name: string;
  servo?: number;
  told?: number;
  read?: number;
  position?: number;
}
export function servoRows(told: readonly ServoJson[] = [], read: readonly ServoJson[] = []): ServoRow[] {
  const rows = new Map<string, ServoRow>();
  const row = (one: ServoJson): ServoRow => {
    const key = String(one.servo ?? one.joint);
    const known = rows.get(key) ?? { name: one.joint ?? '', servo: one.servo };
    rows.set(key, known);
    return known;
  };
  for (const one of told) row(one).told = one.units ?? one.pulse;
  for (const one of read) Object.assign(row(one), { read: one.units ?? one.pulse, position: one.position_rad });
  return [...rows.values()].sort((a, b) => (a.servo ?? 0) - (b.servo ?? 0));
}
