import { describe, expect, it } from 'vitest';
import { ConnectionError, kRetryFirstMs, kRetryMaxMs, RpcClient, RpcError, type Socket } from './rpc';

class FakeSocket implements Socket {
  sent: { id: number; method: string; params: unknown }[] = [];
  onopen: (() => void) | null = null;
  onclose: (() => void) | null = null;
  onmessage: ((event: { data: unknown }) => void) | null = null;
  bufferedAmount = 0;
  send(text: string) {
    this.sent.push(JSON.parse(text));
  }
  close() {
    this.onclose?.();
  }
  answer(message: object) {
    this.onmessage?.({ data: JSON.stringify({ jsonrpc: '2.0', ...message }) });
  }
}

function rig() {
  const sockets: FakeSocket[] = [];
  const timers = new Map<number, { callback: () => void; ms: number }>();
  let lastTimer = 0;
  const seen: string[] = [];
  const client = new RpcClient({
    connect: () => {
      const socket = new FakeSocket();
      sockets.push(socket);
      return socket;
    },
    onOpen: () => seen.push('open'),
    onClose: () => seen.push('close'),
    onMessage: (method) => seen.push(method),
    setTimer: (callback, ms) => {
      timers.set(++lastTimer, { callback, ms });
      return lastTimer;
    },
    clearTimer: (timer) => timers.delete(timer),
    random: () => 1,
  });
  const fire = () => {
    const [id, timer] = [...timers.entries()].at(-1)!;
    timers.delete(id);
    timer.callback();
    return timer.ms;
  };
  return { client, sockets, timers, seen, fire };
}

describe('RpcClient', () => {
  it('gives each answer to who asked', async () => {
    const { client, sockets } = rig();
    client.start();
    sockets[0]!.onopen!();
    const first = client.call('a');
    const second = client.call('b');
    sockets[0]!.answer({ id: 2, result: 'two' });
    sockets[0]!.answer({ id: 1, error: { code: 1, message: 'no', data: { code: 'x' } } });
    await expect(second).resolves.toBe('two');
    await expect(first).rejects.toMatchObject({ code: 1, message: 'no' });
    await expect(first).rejects.toBeInstanceOf(RpcError);
  });

  it('refuses at once while there is no connection', async () => {
    const { client, sockets } = rig();
    client.start();
    await expect(client.call('robot.jog')).rejects.toBeInstanceOf(ConnectionError);
    expect(sockets[0]!.sent).toEqual([]);
  });

  it('never sends again what a lost connection has swallowed', async () => {
    const { client, sockets, fire, seen } = rig();
    client.start();
    sockets[0]!.onopen!();
    const move = client.call('program.run', { text: 'joint J1=10deg' });
    sockets[0]!.onclose!();
    await expect(move).rejects.toMatchObject({ reason: 'closed' });
    fire();
    sockets[1]!.onopen!();
    expect(sockets[1]!.sent).toEqual([]);
    expect(seen).toEqual(['open', 'close', 'open']);
  });

  it('tries again later and later, and soon again once it had worked', () => {
    const { client, sockets, fire } = rig();
    client.start();
    const waits: number[] = [];
    for (let i = 0; i < 7; ++i) {
      sockets.at(-1)!.onclose!();
      waits.push(fire());
    }
    expect(waits[0]).toBe(kRetryFirstMs);
    expect(waits[1]).toBe(2 * kRetryFirstMs);
    expect(waits.at(-1)).toBe(kRetryMaxMs);
    sockets.at(-1)!.onopen!();
    sockets.at(-1)!.onclose!();
    expect(fire()).toBe(kRetryFirstMs);
  });

  it('gives up waiting for an answer that does not come', async () => {
    const { client, sockets, fire } = rig();
    client.start();
    sockets[0]!.onopen!();
    const slow = client.call('a', {}, 50);
    expect(fire()).toBe(50);
    await expect(slow).rejects.toMatchObject({ reason: 'timeout' });
    sockets[0]!.answer({ id: 1, result: 'late' }); // nobody is there any more
  });

  it('takes bytes that are no message without harm', () => {
    const { client, sockets, seen } = rig();
    client.start();
    sockets[0]!.onopen!();
    sockets[0]!.onmessage!({ data: '{' });
    sockets[0]!.onmessage!({ data: new ArrayBuffer(2) });
    sockets[0]!.answer({ method: 'status', params: {} });
    expect(seen).toEqual(['open', 'status']);
  });

  it('stays away after close()', () => {
    const { client, sockets, timers } = rig();
    client.start();
    sockets[0]!.onopen!();
    client.close();
    expect(timers.size).toBe(0);
  });
});
