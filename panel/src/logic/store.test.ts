import { describe, expect, it } from 'vitest';
import { ConnectionError, RpcError } from './rpc';
import { ready } from './status.fixture';
import { isGrave, Store } from './store';
import type { EventJson, RobotStatus } from './types';

function rig() {
  const asked: { method: string; params: Record<string, unknown> }[] = [];
  const answers: Record<string, unknown> = {
    'cell.describe': { title: 'c', version: '1', time_scale: 1, robots: [{ name: 'arm' }], objects: [] },
    'session.open': { role: 'operator' },
    'robot.model': { kind: 'serial' },
    'cell.status': { robots: [] },
    'events.list': { events: [] },
    'lease.take': { epoch: 3, client: 7 },
  };
  const clock = { now: 0 };
  const store = new Store(
    {
      open: true,
      call: <Result>(method: string, params: object = {}) => {
        asked.push({ method, params: params as Record<string, unknown> });
        const answer = answers[method] ?? {};
        return answer instanceof Error ? Promise.reject(answer) : Promise.resolve(answer as Result);
      },
    },
    () => clock.now,
  );
  return { store, asked, answers, clock, methods: () => asked.map((one) => one.method) };
}

const status = (over: Partial<RobotStatus> = {}): RobotStatus => ({ ...ready, ...over });

describe('Store', () => {
  it('learns the cell when it is connected, and asks for nothing that moves', async () => {
    const { store, methods } = rig();
    await store.opened('secret');
    expect(methods()).toEqual(['session.open', 'cell.describe', 'robot.model', 'cell.status', 'procedure.status', 'events.list', 'watch']);
    expect(store.connection.value).toBe('open');
    store.closed();
    expect(store.connection.value).toBe('lost');
  });

  it('knows what its token may do, and why it was turned away', async () => {
    const { store, answers, asked } = rig();
    answers['session.open'] = { role: 'viewer' };
    await store.opened('secret');
    expect(asked[0]!.params).toEqual({ token: 'secret' });
    expect(store.role.value).toBe('viewer');
    answers['session.open'] = new RpcError(1, 'this token is not known');
    await expect(store.opened('other')).rejects.toThrow();
    expect(store.turnedAway.value).toBe('this token is not known');
    answers['session.open'] = { role: 'operator' };
    await store.opened('secret');
    expect(store.turnedAway.value).toBeNull();
  });

  it('says how old what it shows is, where states stay away and where the connection went', async () => {
    const { store, clock } = rig();
    await store.opened('secret');
    clock.now = 1900;
    store.lookAtAge();
    expect(store.age.value).toBeNull();
    clock.now = 3500;
    store.lookAtAge();
    expect(store.age.value).toBe(3);
    store.take('status', { robots: [] });
    expect(store.age.value).toBeNull();
    store.closed();
    expect(store.age.value).toBe(0);
    clock.now = 8000;
    store.lookAtAge();
    expect(store.age.value).toBe(4);
  });

  it('lets nothing begin behind a stop that came while it took control', async () => {
    const { store, methods } = rig();
    const run = store.run('arm', 'joint J1=1deg', 'move');
    void store.stopAll();
    expect(await run).toBe(false);
    expect(methods()).toEqual(['lease.take', 'robot.stop']);
  });

  it('keeps the lease alive while it has one, driven by what comes in', async () => {
    const { store, methods, clock } = rig();
    await store.control('arm');
    const renewals = () => methods().filter((one) => one === 'lease.renew').length;
    store.take('status', { robots: [status({ lease: { client: 7, epoch: 3 } })] });
    expect(store.lease('arm')).toBe('mine');
    expect(renewals()).toBe(1);
    store.take('status', { robots: [status({ lease: { client: 7, epoch: 3 } })] });
    expect(renewals()).toBe(1);
    clock.now = 400;
    store.take('status', { robots: [status({ lease: { client: 7, epoch: 3 } })] });
    expect(renewals()).toBe(2);
    clock.now = 800;
    store.take('status', { robots: [status({ lease: { client: 8, epoch: 4 } })] });
    expect(store.lease('arm')).toBe('other');
    expect(renewals()).toBe(2);
  });

  it('keeps control alive for a procedure that it has started, and answers none that others have', async () => {
    const { store, answers, asked } = rig();
    const procedure = { robot: 'arm', number: 1, client: 9, over: false, phase: 'asking', steps: [], place: 0 };
    answers['procedure.start'] = procedure;
    expect(await store.startProcedure('arm', 'recover')).toBeNull();
    expect(asked.at(-1)!.params).toEqual({ robot: 'arm', kind: 'recover' });
    expect(store.ownsProcedure('arm')).toBe(true);
    store.take('status', { robots: [status({ lease: { client: 9, epoch: 3 } })] });
    expect(asked.at(-1)!.method).toBe('lease.renew');
    store.take('procedure', { ...procedure, number: 2, client: 12 });
    expect(store.ownsProcedure('arm')).toBe(false);
  });

  it('says why an answer was refused where it was asked, and notes nothing', async () => {
    const { store, answers } = rig();
    answers['procedure.answer'] = new RpcError(1, "'20': needs a unit");
    expect(await store.answerProcedure('arm', '20')).toBe("'20': needs a unit");
    expect(store.notes.value).toHaveLength(0);
    answers['procedure.answer'] = new ConnectionError('timeout');
    expect(await store.answerProcedure('arm', '20')).toBe('');
    expect(store.notes.value.at(-1)).toMatchObject({ kind: 'lost' });
  });

  it('knows nobody as itself behind a lost connection', async () => {
    const { store } = rig();
    await store.control('arm');
    store.closed();
    store.take('status', { robots: [status({ lease: { client: 7, epoch: 3 } })] });
    expect(store.lease('arm')).toBe('other');
  });

  it('stops everything without the lease', async () => {
    const { store, asked } = rig();
    await store.stopAll();
    expect(asked).toEqual([{ method: 'robot.stop', params: {} }]);
  });

  it('notes a refusal down in the words of the server, and does not go on', async () => {
    const { store, methods, answers } = rig();
    answers['lease.take'] = new RpcError(1, 'somebody else has it', { code: 'lease_held' });
    expect(await store.enable('arm')).toBe(false);
    expect(methods()).toEqual(['lease.take']);
    expect(store.notes.value).toMatchObject([
      { kind: 'refused', robot: 'arm', text: 'somebody else has it', data: { code: 'lease_held' } },
    ]);
    answers['lease.take'] = new ConnectionError('closed');
    await store.run('arm', 'joint J1=1deg', 'move');
    expect(store.notes.value.at(-1)).toMatchObject({ kind: 'lost' });
    store.dismiss(store.notes.value[0]!.id);
    expect(store.notes.value).toHaveLength(1);
  });

  it('keeps notes until somebody has read them, and counts what it has no room for', () => {
    const { store } = rig();
    for (let i = 0; i < 505; ++i) store.note('refused', `note ${i}`);
    expect(store.notes.value).toHaveLength(500);
    expect(store.notes.value[0]!.text).toBe('note 5');
    expect(store.notesGone.value).toBe(5);
    store.dismissAll();
    expect(store.notes.value).toHaveLength(0);
    expect(store.notesGone.value).toBe(0);
  });

  it('keeps events of a day, also behind a connection that was lost, and says how many are before them', async () => {
    const { store, answers } = rig();
    const event = (number: number, at_ms = number): EventJson => ({ number, at_ms, robot: 'arm', kind: 'state' });
    const all = (from: number, to: number, at_ms?: number) => Array.from({ length: to - from + 1 }, (_, i) => event(from + i, at_ms));
    answers['events.list'] = { events: all(11, 1010) };
    await store.opened('secret');
    expect(store.eventsGone.value).toBe(10);
    for (const one of all(1011, 1300)) store.take('event', one);
    answers['events.list'] = { events: all(501, 1500) };
    await store.opened('secret');
    expect(store.events.value.map((one) => one.number)).toEqual(all(11, 1500).map((one) => one.number));
    for (const one of all(1501, 5020)) store.take('event', one);
    expect(store.events.value).toHaveLength(5000);
    expect(store.eventsGone.value).toBe(20);
    // Another life of the controller counts anew.
    answers['events.list'] = { events: all(1, 3, 99) };
    await store.opened('secret');
    expect(store.events.value).toHaveLength(3);
    expect(store.eventsGone.value).toBe(0);
  });

  it('asks for what happens between its list and its watch, and calls nothing seen that came while it was cut off', async () => {
    const { store, answers, asked } = rig();
    const fault = (number: number): EventJson => ({ number, at_ms: number, robot: 'arm', kind: 'fault' });
    answers['events.list'] = { events: [fault(1), fault(2)] };
    await store.opened('secret');
    expect(asked.at(-1)).toMatchObject({ method: 'watch', params: { after: 2 } });
    expect(store.unseen.value).toBe(0);
    store.closed();
    answers['events.list'] = { events: [fault(1), fault(2), fault(3)] };
    await store.opened('secret');
    expect(store.unseen.value).toBe(1);
    store.seen.value = 3;
    expect(store.unseen.value).toBe(0);
  });

  it('counts what nobody has looked at yet, and takes each event once', () => {
    const { store } = rig();
    const event = (number: number, over: Partial<EventJson>): EventJson => ({
      number,
      at_ms: 0,
      robot: 'arm',
      kind: 'state',
      ...over,
    });
    store.take('event', event(1, {}));
    store.take('event', event(2, { kind: 'fault' }));
    store.take('event', event(2, { kind: 'fault' }));
    expect(store.events.value).toHaveLength(2);
    expect(store.unseen.value).toBe(1);
    store.seen.value = 2;
    expect(store.unseen.value).toBe(0);
    expect(isGrave(event(3, { kind: 'stop', cause: 'client' }))).toBe(false);
    expect(isGrave(event(3, { kind: 'job', phase: 'failed' }))).toBe(true);
  });
});
