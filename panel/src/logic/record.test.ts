// Against files that `sinew run --record` wrote: a move of the BigRobotArm, one leg of the platform.
import { describe, expect, it } from 'vitest';
import { crc32, McapError, readMcap } from './mcap';
import { lastBefore, lengthOf, readRecord, standAt } from './record';

async function fixture(name: string): Promise<Uint8Array> {
  // @ts-expect-error  the page itself has no node; its tests run in one
  const [{ readFileSync }, { gunzipSync }] = await Promise.all([import('node:fs'), import('node:zlib')]);
  const unpacked = gunzipSync(readFileSync(new URL(name, import.meta.url))) as Uint8Array;
  return new Uint8Array(unpacked);
}
const arm = await fixture('./bigrobotarm.fixture.mcap.gz');
const legs = await fixture('./hexapod.fixture.mcap.gz');
const whatOf = (bytes: Uint8Array): string => {
  try {
    readMcap(bytes);
    return 'none';
  } catch (error) {
    return error instanceof McapError ? error.what : `other: ${String(error)}`;
  }
};

describe('MCAP', () => {
  it('has the checksum of zlib', () => {
    expect(crc32(new TextEncoder().encode('123456789'))).toBe(0xcbf43926);
  });
  it('is read whole', () => {
    const file = readMcap(arm);
    expect(file.whole).toBe(true);
    expect(file.library).toMatch(/^sinew /);
    expect([...file.channels.values()].map((one) => one.topic)).toEqual(
      ['joint_states', 'state', 'events', 'wire', 'tool'].map((one) => `/bigrobotarm/${one}`),
    );
    const count = (topic: string) =>
      file.messages.filter((one) => file.channels.get(one.channel)!.topic.endsWith(topic)).length;
    // What `sinew record` says of the same file.
    expect([count('joint_states'), count('state'), count('events'), count('wire'), count('tool')]).toEqual([73, 10, 14, 8, 4]);
  });
  it('that was cut off anywhere gives what stands before the cut', () => {
    let last = -1;
    for (let end = 4000; end < arm.length; end += 3001) {
      const cut = readMcap(arm.slice(0, end));
      expect(cut.messages.length).toBeGreaterThanOrEqual(Math.max(0, last));
      last = cut.messages.length;
    }
    expect(readMcap(arm.slice(0, 12000)).whole).toBe(false);
  });
  it('that was damaged is refused', () => {
    const damaged = arm.slice();
    const text = new TextEncoder().encode('"position_rad":');
    let found = -1;
    for (let i = 8000; i < damaged.length && found < 0; ++i) if (text.every((b, k) => damaged[i + k] === b)) found = i;
    expect(found).toBeGreaterThan(0);
    damaged[found + text.length] = damaged[found + text.length]! ^ 1;
    expect(whatOf(damaged)).toBe('checksum');
  });
  it('of another kind, of nothing, of noise: a reason, never a crash', () => {
    expect(whatOf(new Uint8Array())).toBe('magic');
    expect(whatOf(new TextEncoder().encode('t_s,base\n0,1\n'))).toBe('magic');
    expect(whatOf(arm.slice(0, 8))).toBe('empty');
    // Noise with a fixed seed behind the head.
    let seed = 7;
    for (let run = 0; run < 200; ++run) {
      const noise = arm.slice(0, 9000);
      for (let k = 0; k < 20; ++k) {
        seed = (seed * 1103515245 + 12345) % 2147483648;
        noise[8 + (seed % 8992)] = (seed >> 8) & 255;
      }
      expect(whatOf(noise)).not.toMatch(/^other/);
    }
  });
});

describe('a record', () => {
  it('says whose it is and has every row, in SI', () => {
    const record = readRecord(arm);
    expect([record.robot, record.model, record.whole, record.lost]).toEqual(['bigrobotarm', 'bigrobotarm', true, 0]);
    expect(record.joints.map((one) => one.name)).toEqual(['base', 'shoulder', 'elbow', 'wrist_rotate', 'wrist']);
    expect(record.frames.length).toBe(73);
    // The last row of `sinew record --csv`.
    expect(lengthOf(record)).toBeCloseTo(0.793211, 6);
    const end = record.frames.at(-1)!.robots['bigrobotarm']!.joints[0]!;
    expect(end.position).toBeCloseTo(0.104639201, 8);
    expect(end.commanded).toBeCloseTo(0.104719755, 8);
    expect(end.measured).toBe(false);
    expect(record.events.some((one) => one.kind === 'started')).toBe(true);
  });
  it('of a platform has legs in m, and where its plate was', () => {
    const record = readRecord(legs);
    expect(record.joints.map((one) => one.measure)).toEqual(Array(6).fill('length'));
    const end = standAt(record, lengthOf(record))!;
    expect(end.joints[0]).toBeCloseTo(0.2684, 5);
    expect(end.platform!.p[2]).toBeGreaterThan(0.1);
    expect(Math.hypot(...end.platform!.q)).toBeCloseTo(1, 6);
  });
  it('shows nobody where nothing was known yet', () => {
    const record = readRecord(legs);
    const first = record.frames.find((one) => one.robots['hexapod']!.joints.every((joint) => !Number.isNaN(joint.position)))!;
    expect(standAt(record, -1)).toBeNull();
    expect(standAt(record, first.t)).not.toBeNull();
  });
  it('is searched by time', () => {
    const all = [0, 1, 2, 2.5].map((t) => ({ t }));
    expect([-1, 0, 0.5, 2, 2.4, 9].map((t) => lastBefore(all, t))).toEqual([-1, 0, 0, 2, 2, 3]);
    expect(lastBefore([], 1)).toBe(-1);
  });
});
