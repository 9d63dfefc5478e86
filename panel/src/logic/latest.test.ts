import { describe, expect, it } from 'vitest';
import { Latest } from './latest';

function rig() {
  const asked: { question: number; resolve: (answer: string) => void }[] = [];
  const told: [number, string][] = [];
  const timers: (() => void)[] = [];
  const clock = { now: 0 };
  const latest = new Latest<number, string>({
    ask: (question) => new Promise((resolve) => asked.push({ question, resolve })),
    onAnswer: (question, answer) => told.push([question, answer]),
    onError: () => undefined,
    intervalMs: 100,
    now: () => clock.now,
    setTimer: (callback) => timers.push(callback),
  });
  return { latest, asked, told, timers, clock };
}
const settle = () => new Promise((resolve) => setTimeout(resolve, 0));

describe('Latest', () => {
  it('has one question under way and asks only the latest behind it', async () => {
    const { latest, asked, told, clock } = rig();
    latest.put(1);
    latest.put(2);
    latest.put(3);
    expect(asked.map((one) => one.question)).toEqual([1]);
    clock.now = 200;
    asked[0]!.resolve('old');
    await settle();
    expect(asked.map((one) => one.question)).toEqual([1, 3]);
    asked[1]!.resolve('new');
    await settle();
    expect(told).toEqual([[3, 'new']]);
  });

  it('keeps its distance', async () => {
    const { latest, asked, timers, clock } = rig();
    latest.put(1);
    asked[0]!.resolve('a');
    await settle();
    clock.now = 40;
    latest.put(2);
    expect(asked).toHaveLength(1);
    clock.now = 100;
    timers[0]!();
    expect(asked).toHaveLength(2);
  });

  it('forgets', async () => {
    const { latest, asked, told } = rig();
    latest.put(1);
    latest.forget();
    asked[0]!.resolve('a');
    await settle();
    expect(told).toEqual([]);
  });
});
