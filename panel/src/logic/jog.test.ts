import { describe, expect, it } from 'vitest';
import { along, Jog, kJogExpiryS, kJogUnansweredMax, watchPage, type JogEnd, type JogWish } from './jog';

function rig(answer: 'at once' | 'never' | Error = 'at once') {
  const sent: { wish: JogWish; expiry: number }[] = [];
  const ends: JogEnd[] = [];
  let timer: (() => void) | null = null;
  const state = { answer };
  const jog = new Jog({
    send: (wish, expiry) => {
      sent.push({ wish, expiry });
      if (state.answer === 'at once') return Promise.resolve();
      if (state.answer === 'never') return new Promise(() => undefined);
      return Promise.reject(state.answer);
    },
    onEnd: (why) => ends.push(why),
    setTimer: (callback) => {
      timer = callback;
      return 1;
    },
    clearTimer: () => {
      timer = null;
    },
  });
  const turn = async () => {
    await Promise.resolve();
    await Promise.resolve();
    const due = timer;
    timer = null;
    due?.();
  };
  const speeds = () => sent.map((one) => one.wish.velocity);
  return { jog, sent, ends, turn, speeds, state, waits: () => timer !== null };
}

const wish = (velocity: number[], frame: JogWish['frame'] = 'base'): JogWish => ({
  robot: 'arm',
  frame,
  velocity,
});

describe('Jog', () => {
  it('sends at once, again and again while held, and a zero at the release', async () => {
    const { jog, sent, ends, turn, speeds, waits } = rig();
    jog.hold('button', wish([0.1, 0, 0]));
    await turn();
    await turn();
    jog.release('button');
    expect(speeds()).toEqual([[0.1, 0, 0], [0.1, 0, 0], [0.1, 0, 0], [0, 0, 0]]);
    expect(sent.every((one) => one.expiry === kJogExpiryS)).toBe(true);
    expect(ends).toEqual(['released']);
    expect(waits()).toBe(false);
    await turn();
    expect(sent).toHaveLength(4);
  });

  it('adds what several hold, and goes on with what is left', async () => {
    const { jog, turn, speeds } = rig();
    jog.hold('x', wish([0.1, 0, 0]));
    jog.hold('y', wish([0, 0.2, 0]));
    await turn();
    jog.release('x');
    await turn();
    jog.release('y');
    expect(speeds()).toEqual([[0.1, 0, 0], [0.1, 0.2, 0], [0, 0.2, 0], [0, 0, 0]]);
  });

  it('counts stops while nothing is held too: who waits to begin learns of them', () => {
    const { jog } = rig();
    const before = jog.stops;
    jog.stop('stopped');
    expect(jog.stops).not.toBe(before);
  });

  it('lets go of one frame when another is held', async () => {
    const { jog, turn, sent } = rig();
    jog.hold('x', wish([0.1, 0, 0]));
    jog.hold('j', wish([0.5], 'joint'));
    await turn();
    expect(sent.at(-1)!.wish).toEqual(wish([0.5], 'joint'));
    expect(jog.sources).toEqual(['j']);
  });

  for (const why of ['blur', 'hidden', 'lost', 'stopped'] as const) {
    it(`${why}: lets go, and holds nothing until it is pressed anew`, async () => {
      const { jog, turn, ends, speeds } = rig();
      jog.hold('x', wish([0.1]));
      jog.stop(why);
      jog.release('x');
      await turn();
      expect(ends).toEqual([why]);
      expect(speeds()).toEqual(why === 'lost' ? [[0.1]] : [[0.1], [0]]);
      expect(jog.moving).toBe(false);
    });
  }

  it('stops where the way there does not answer', async () => {
    const { jog, turn, ends, sent } = rig('never');
    jog.hold('x', wish([0.1]));
    for (let i = 0; i < 10; ++i) await turn();
    expect(ends).toEqual(['slow']);
    expect(sent).toHaveLength(kJogUnansweredMax + 1); // and the zero
  });

  it('stops where it is refused, and where the connection went', async () => {
    const refused = rig(Object.assign(new Error('no lease'), { code: 1 }));
    refused.jog.hold('x', wish([0.1]));
    await refused.turn();
    expect(refused.ends).toEqual(['refused']);
    const lost = rig(new Error('closed'));
    lost.jog.hold('x', wish([0.1]));
    await lost.turn();
    expect(lost.ends).toEqual(['lost']);
  });

  it('does not hold an old refusal against a new hold', async () => {
    const { jog, turn, ends, state } = rig(Object.assign(new Error('no'), { code: 1 }));
    jog.hold('x', wish([0.1]));
    jog.release('x');
    state.answer = 'at once';
    jog.hold('x', wish([0.1]));
    await turn();
    await turn();
    expect(ends).toEqual(['released']);
    expect(jog.moving).toBe(true);
  });
});

describe('watchPage', () => {
  it('ends a hold when the window or the page goes', () => {
    const view = new EventTarget();
    const page = Object.assign(new EventTarget(), { visibilityState: 'visible' });
    const { jog, ends } = rig();
    const off = watchPage(jog, view as Window, page as unknown as Document);
    jog.hold('x', wish([0.1]));
    page.dispatchEvent(new Event('visibilitychange'));
    expect(jog.moving).toBe(true);
    page.visibilityState = 'hidden';
    page.dispatchEvent(new Event('visibilitychange'));
    jog.hold('x', wish([0.1]));
    view.dispatchEvent(new Event('blur'));
    off();
    jog.hold('x', wish([0.1]));
    view.dispatchEvent(new Event('blur'));
    expect(ends).toEqual(['hidden', 'blur']);
    expect(jog.moving).toBe(true);
  });
});

describe('along', () => {
  it('has one number that is not zero', () => {
    expect(along(3, 1, -0.5)).toEqual([0, -0.5, 0]);
  });
});
