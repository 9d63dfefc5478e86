/**
 * The cell as the page knows it. Messages of the server come in, signals go out; nothing here
 * touches the page. What is asked for in words of the domain (`control`, `enable`, `stop`) goes
 * out from here too, so that every view asks in the same way.
 */
import { batch, computed, signal } from '@preact/signals';
import { refusalSentence } from '../i18n';
import type { ProcedureJson, ProcedureKind } from './procedure';
import { ConnectionError, RpcError } from './rpc';
import type {
  CellDescription,
  CheckJson,
  EventJson,
  JobJson,
  PreviewJson,
  RobotModel,
  RobotStatus,
  ToolRow,
} from './types';

export interface Caller {
  call<Result = unknown>(method: string, params?: object, timeoutMs?: number): Promise<Result>;
  readonly open: boolean;
}

export type Connection = 'connecting' | 'open' | 'lost';
/** What the token of this page may do: viewers watch, and may stop. */
export type Role = 'operator' | 'viewer';

/** Something to tell in passing; it stays in the list of notes. */
export interface Note {
  id: number;
  at: number;
  kind: 'info' | 'refused' | 'lost';
  robot?: string;
  text: string;
  /** What a refusal tells beside its words, by which other languages say it. */
  data?: unknown;
}

/** As much as a page can hold all day; what goes is counted. */
const kEventsMax = 5000;
const kNotesMax = 500;
const kRateHz = 25;
/** A lease lives for a second; messages of the server drive its renewal, also in a hidden tab. */
const kRenewMs = 300;
/** States come 25 times a second; after so long without one, what is shown is old. */
const kSilentMs = 2000;

export type Lease = 'mine' | 'other' | 'free';

export class Store {
  readonly connection = signal<Connection>('connecting');
  readonly role = signal<Role>('operator');
  /** Why the controller does not take this page's token. */
  readonly turnedAway = signal<string | null>(null);
  /** How old what is shown is, s; nothing while states come. */
  readonly age = signal<number | null>(null);
  readonly cell = signal<CellDescription | null>(null);
  readonly models = signal<Record<string, RobotModel>>({});
  readonly status = signal<Record<string, RobotStatus>>({});
  /** The procedure of each robot that is under way, or the last one. */
  readonly procedures = signal<Record<string, ProcedureJson>>({});
  /** The robots are shown, until somebody moves one. */
  readonly demonstration = signal(false);
  readonly events = signal<EventJson[]>([]);
  /** Number of the last event that somebody has seen in the list. */
  readonly seen = signal(0);
  readonly notes = signal<Note[]>([]);
  /** Notes that nobody has dismissed and there was no room for. */
  readonly notesGone = signal(0);
  /** Events before the first one here. */
  readonly eventsGone = computed(() => Math.max(0, (this.events.value[0]?.number ?? 1) - 1));
  /** Who we are to the server; nothing before the first lease. */
  readonly client = signal<number | null>(null);
  readonly robots = computed(() => this.cell.value?.robots ?? []);
  readonly faults = computed(() => Object.values(this.status.value).filter((one) => one.fault));
  readonly unseen = computed(
    () => this.events.value.filter((one) => one.number > this.seen.value && isGrave(one)).length,
  );

  private lastNote = 0;
  private renewed = -Infinity;
  private heard = -Infinity;
  private stops = 0;

  constructor(
    private readonly rpc: Caller,
    private readonly now: () => number = () => performance.now(),
  ) {}

  /** The connection is there: everything is asked anew, and nothing that moves is. */
  async opened(token: string): Promise<void> {
    this.client.value = null;
    const told = await this.rpc.call<{ role: Role }>('session.open', { token }).catch((error: Error) => {
      if (error instanceof RpcError) this.turnedAway.value = error.message;
      throw error;
    });
    const cell = await this.rpc.call<CellDescription>('cell.describe');
    const models = await this.ofEach<RobotModel>(cell, 'robot.model');
    const status = await this.rpc.call<{ robots: RobotStatus[] }>('cell.status');
    const procedures = await this.ofEach<ProcedureJson>(cell, 'procedure.status');
    const past = await this.rpc.call<{ events: EventJson[] }>('events.list');
    // What happens between the list and the watch comes too.
    const after = past.events.at(-1)?.number ?? 0;
    await this.rpc.call('watch', { rate_hz: kRateHz, after });
    batch(() => {
      this.role.value = told.role;
      this.turnedAway.value = null;
      this.cell.value = cell;
      this.models.value = models;
      this.procedures.value = procedures;
      this.take('status', status);
      this.events.value = joined(this.events.peek(), past.events).slice(-kEventsMax);
      // What came while this page was cut off is news to it.
      const first = this.connection.peek() === 'connecting';
      if (first || this.seen.peek() > after) this.seen.value = after;
      this.connection.value = 'open';
    });
  }

  /** What a cell says of itself changes where a camera is calibrated. */
  async describeAgain(): Promise<void> {
    this.cell.value = await this.rpc.call<CellDescription>('cell.describe');
  }

  /** One question a robot, all at once: a slow computer waits once. */
  private async ofEach<Answer>(cell: CellDescription, method: string): Promise<Record<string, Answer>> {
    const asked = cell.robots.map(async ({ name }) => [name, await this.rpc.call<Answer>(method, { robot: name })] as const);
    return Object.fromEntries(await Promise.all(asked));
  }

  closed(): void {
    if (this.cell.value) this.connection.value = 'lost';
    this.client.value = null;
    this.lookAtAge();
  }

  /** Asked now and then, since silence does not come by itself. */
  lookAtAge(): void {
    const age = this.now() - this.heard;
    const old = this.cell.value !== null && (this.connection.value !== 'open' || age > kSilentMs);
    this.age.value = old ? Math.floor(age / 1000) : null;
  }

  take(method: string, params: unknown): void {
    if (method === 'status') {
      const status = { ...this.status.value };
      const told = params as { robots: RobotStatus[]; demonstration?: boolean };
      for (const one of told.robots) status[one.robot] = one;
      this.status.value = status;
      this.demonstration.value = told.demonstration ?? false;
      this.heard = this.now();
      if (this.age.peek() !== null && this.connection.peek() === 'open') this.age.value = null;
      this.renew();
    } else if (method === 'event') {
      const event = params as EventJson;
      if (event.number <= (this.events.value.at(-1)?.number ?? 0)) return;
      this.events.value = [...this.events.value, event].slice(-kEventsMax);
    } else if (method === 'procedure') {
      const procedure = params as ProcedureJson;
      this.procedures.value = { ...this.procedures.value, [procedure.robot]: procedure };
    } else if (method === 'job') {
      const job = params as JobJson;
      const status = this.status.value[job.robot];
      if (status) this.status.value = { ...this.status.value, [job.robot]: { ...status, job } };
    }
  }

  /** How much faster a robot's own time runs than ours. */
  timeScale(robot: string): number {
    return this.robots.value.find((one) => one.name === robot)?.time_scale ?? 1;
  }

  lease(robot: string): Lease {
    const holder = this.status.value[robot]?.lease;
    if (!holder) return 'free';
    return holder.client === this.client.value ? 'mine' : 'other';
  }

  private renew(): void {
    const now = this.now();
    if (now - this.renewed < kRenewMs || this.client.value === null) return;
    const holds = Object.keys(this.status.value).some((robot) => this.lease(robot) === 'mine');
    if (!holds) return;
    this.renewed = now;
    this.rpc.call('lease.renew').catch(() => undefined);
  }

  note(kind: Note['kind'], text: string, robot?: string, data?: unknown): void {
    const note: Note = { id: ++this.lastNote, at: Date.now(), kind, text, robot, data };
    const all = [...this.notes.value, note];
    this.notesGone.value += Math.max(0, all.length - kNotesMax);
    this.notes.value = all.slice(-kNotesMax);
  }
  dismiss(id: number): void {
    this.notes.value = this.notes.value.filter((one) => one.id !== id);
  }
  dismissAll(): void {
    this.notes.value = [];
    this.notesGone.value = 0;
  }

  /** Asks; whoever asks sees to what goes wrong. */
  call<Result>(method: string, params: object = {}): Promise<Result> {
    return this.rpc.call<Result>(method, params);
  }

  /** Asks, and notes down why not. */
  async ask<Result = unknown>(method: string, params: { robot?: string; [name: string]: unknown }): Promise<Result | null> {
    try {
      return await this.rpc.call<Result>(method, params);
    } catch (error) {
      this.noteError(error, params.robot);
      return null;
    }
  }

  noteError(error: unknown, robot?: string): void {
    if (error instanceof RpcError) this.note('refused', error.message, robot, error.data);
    else if (error instanceof ConnectionError) this.note('lost', error.reason, robot);
    else this.note('refused', String(error), robot);
  }

  /** Everything, whoever has the lease. */
  async stopAll(): Promise<boolean> {
    ++this.stops;
    return (await this.ask('robot.stop', {})) !== null;
  }

  /** @return  whether what was wanted with it may go on: not behind a stop that came meanwhile */
  async control(robot: string, takeOver = false): Promise<boolean> {
    if (this.lease(robot) === 'mine') return true;
    const before = this.stops;
    const lease = await this.ask<{ client: number }>('lease.take', { robot, take_over: takeOver });
    if (!lease) return false;
    this.client.value = lease.client;
    return before === this.stops;
  }
  async release(robot: string): Promise<void> {
    await this.ask('lease.release', { robot });
  }

  async enable(robot: string): Promise<boolean> {
    if (!(await this.control(robot))) return false;
    return (await this.ask('robot.enable', { robot })) !== null;
  }
  async disable(robot: string): Promise<void> {
    if (await this.control(robot)) await this.ask('robot.disable', { robot });
  }
  async acknowledge(robot: string): Promise<void> {
    if (await this.control(robot)) await this.ask('robot.acknowledge', { robot });
  }
  /** @return  whether all boards have passed */
  async selfTest(robot: string): Promise<boolean> {
    if (!(await this.control(robot))) return false;
    return (await this.ask('robot.self_test', { robot })) !== null;
  }
  /** Motors off, or holding again. */
  async freeDrive(robot: string, on: boolean): Promise<boolean> {
    if (!(await this.control(robot))) return false;
    return (await this.ask('robot.free_drive', { robot, on })) !== null;
  }
  async feed(robot: string, share: number): Promise<void> {
    if (await this.control(robot)) await this.ask('robot.feed', { robot, share });
  }

  /** Rows, as the preview showed them. */
  async run(robot: string, text: string, name: string): Promise<boolean> {
    if (!(await this.control(robot))) return false;
    return (await this.ask('program.run', { robot, text, name })) !== null;
  }

  /** The hold of this robot's program is guarded by another client. */
  guarded(robot: string): boolean {
    const guard = this.status.value[robot]?.job?.held_by;
    return guard !== undefined && guard !== this.client.value;
  }
  /** Goes on with what is held, under this page's control where the client that ran it is gone. */
  async resume(robot: string): Promise<void> {
    const lost = this.status.value[robot]?.job?.client_lost;
    if (lost && !(await this.control(robot, this.lease(robot) === 'other'))) return;
    await this.ask('robot.resume', { robot, ...(this.guarded(robot) ? { take_over: true } : {}) });
  }

  /** One row, as its own program. @return  why not: a refusal stands beside what was pressed */
  async runRow(robot: string, text: string, name: string): Promise<string | null> {
    if (!(await this.control(robot))) return '';
    return this.attempt(robot, () => this.rpc.call('program.run', { robot, text, name }));
  }
  private async attempt(robot: string, call: () => Promise<unknown>): Promise<string | null> {
    try {
      await call();
      return null;
    } catch (error) {
      if (error instanceof RpcError) return refusalSentence(error);
      this.noteError(error, robot);
      return '';
    }
  }

  /** Homing, recovery or commissioning, step by step; it takes control for this page by itself. */
  async startProcedure(robot: string, kind: ProcedureKind, how: { take_over?: boolean; anew?: boolean } = {}): Promise<string | null> {
    return this.steer('procedure.start', { robot, kind, ...how });
  }
  answerProcedure(robot: string, answer: string): Promise<string | null> {
    return this.steer('procedure.answer', { robot, answer });
  }
  backProcedure(robot: string): Promise<string | null> {
    return this.steer('procedure.back', { robot });
  }
  cancelProcedure(robot: string): Promise<string | null> {
    return this.steer('procedure.cancel', { robot });
  }
  /** @return  why not: a refusal stands beside its question, not among the notes */
  private steer(method: string, params: { robot: string; [name: string]: unknown }): Promise<string | null> {
    return this.attempt(params.robot, async () => {
      const told = await this.rpc.call<ProcedureJson>(method, params);
      batch(() => {
        // The lease that it has taken is ours, and lives on our messages.
        if (method === 'procedure.start') this.client.value = told.client;
        this.take('procedure', told);
      });
    });
  }
  ownsProcedure(robot: string): boolean {
    const one = this.procedures.value[robot];
    return one !== undefined && !one.over && one.client === this.client.value;
  }

  /** ms that a question without work takes there and back. */
  async roundTrip(): Promise<number> {
    const begin = performance.now();
    await this.rpc.call('objects.list');
    return performance.now() - begin;
  }

  /** A verdict for each row; what it calls is brought along. */
  check(
    robot: string,
    program: { text: string; points: string; called: Record<string, string> },
    timeoutMs?: number,
  ): Promise<CheckJson> {
    return this.rpc.call<CheckJson>('program.check', { robot, ...program }, timeoutMs);
  }

  preview(robot: string, target: PreviewTarget, timeoutMs?: number): Promise<PreviewJson> {
    return this.rpc.call<PreviewJson>('robot.preview', { robot, ...target }, timeoutMs);
  }
}

export interface PreviewTarget {
  joints?: number[];
  tool?: number[] | ToolRow;
  text?: string;
  line?: boolean;
  speed?: number;
  samples?: number;
}

/** The server tells its last events only; older ones that are here stay, if they are of its same life. */
function joined(here: readonly EventJson[], told: readonly EventJson[]): EventJson[] {
  const first = told[0];
  const same = here.some((one) => one.number === first?.number && one.at_ms === first.at_ms);
  return first && same ? [...here.filter((one) => one.number < first.number), ...told] : [...told];
}

/** What somebody should look at, even later. */
export function isGrave(event: EventJson): boolean {
  return (
    event.kind === 'fault' ||
    event.kind === 'notice' ||
    (event.kind === 'stop' && event.cause !== 'client') ||
    (event.kind === 'job' && event.phase === 'failed')
  );
}

/** Its position is one number a joint, not an interval and not nothing. */
export const isPlaceKnown = ({ position }: RobotStatus): boolean => position !== 'lost' && position !== 'uncertain';
export const isAtRest = ({ state }: RobotStatus): boolean => state !== 'moving' && state !== 'stopping';

/** A joint's number, whichever unit it has. */
export const positionOf = (joint: RobotStatus['joints'][number]): number | undefined =>
  joint.commanded_rad ?? joint.commanded_m ?? joint.position_rad ?? joint.position_m;
export const measuredOf = (joint: RobotStatus['joints'][number]): number | undefined =>
  joint.position_rad ?? joint.position_m ?? joint.commanded_rad ?? joint.commanded_m;

export const jointsOf = (
  status: RobotStatus | undefined,
  read: (joint: RobotStatus['joints'][number]) => number | undefined = measuredOf,
): number[] | null => {
  const q = status?.joints.map(read);
  return q && q.every((one) => one !== undefined) ? (q as number[]) : null;
};

export const jointLimits = (joint: RobotModel['joints'][number]) => ({
  lower: joint.lower_rad ?? joint.lower_m ?? 0,
  upper: joint.upper_rad ?? joint.upper_m ?? 0,
  home: joint.home_rad ?? joint.home_m ?? 0,
  velocity: joint.velocity_max_rad_s ?? joint.velocity_max_m_s ?? 0,
  measure: joint.kind === 'prismatic' ? ('length' as const) : ('angle' as const),
});
