import { describe, expect, it } from 'vitest';
import { bytesOf, fetchRecord, sizeText } from './records';

const kWhole = Uint8Array.from({ length: 1000 }, (_, i) => (i * 7) % 256);

const controller = (part: number, size = kWhole.length) => ({
  open: true,
  asked: [] as number[],
  call<Result>(_: string, params: object = {}): Promise<Result> {
    const { offset } = params as { offset: number };
    this.asked.push(offset);
    const bytes = kWhole.slice(offset, offset + part);
    const data = btoa(String.fromCharCode(...bytes));
    return Promise.resolve({ data, offset, size_bytes: size, end: offset + bytes.length >= size } as Result);
  },
});

describe('a record', () => {
  it('comes part by part, as it is', async () => {
    const rpc = controller(300);
    const shares: number[] = [];
    const parts = (await fetchRecord(rpc, 'a.mcap', 'mcap', (share) => shares.push(share)))!;
    expect(rpc.asked).toEqual([0, 300, 600, 900]);
    expect([...new Uint8Array(await new Blob(parts).arrayBuffer())]).toEqual([...kWhole]);
    expect(shares).toEqual([0.3, 0.6, 0.9, 1]);
  });

  it('ends where no more bytes come, and where nobody wants it any more', async () => {
    expect((await fetchRecord(controller(300, 5000), 'a.mcap', 'mcap'))!.length).toBe(5);
    let wanted = 2;
    const rpc = controller(300);
    expect(await fetchRecord(rpc, 'a.mcap', 'csv', undefined, () => wanted-- > 0)).toBeNull();
    expect(rpc.asked).toEqual([0, 300]);
  });

  it('has every byte, and a size in words', () => {
    expect([...bytesOf('AP/+')]).toEqual([0, 255, 254]);
    expect([10, 340_000, 1_234_567, 134_217_728].map(sizeText)).toEqual(['1 kB', '340 kB', '1.2 MB', '134 MB']);
  });
});
