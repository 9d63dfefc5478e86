/**
 * Hold to move. While anything is held a velocity goes out twenty times a second, and each counts
 * for 0.15 s only: whatever breaks on the way (this page, the browser, the network, the server's
 * patience) the robot comes to rest. What ends a hold is a release, a pointer that is cancelled or
 * lost, a window without focus, a hidden page, control that another client has taken, a connection
 * that went or does not answer.
 *
 *            hold(source)                    hold(another)
 *   idle ------------------> moving <------------------------
 *    ^                         |  release(last), stop(why),
 *    |   one zero velocity     |  refused, no answer to 4
 *    +-------------------------+
 *
 * A hold that was ended by anything but its own release has to be pressed anew.
 */
import type { JogFrame } from './types';

export const kJogIntervalMs = 50;
export const kJogExpiryS = 0.15;
/** So many velocities without an answer, and the way there is too slow to jog over. */
export const kJogUnansweredMax = 4;

export interface JogWish {
  robot: string;
  frame: JogFrame;
  /** rad/s and m/s, as many numbers as the frame has. */
  velocity: number[];
}

export type JogEnd = 'released' | 'blur' | 'hidden' | 'taken' | 'lost' | 'slow' | 'refused' | 'stopped';

export interface JogOptions {
  /** Resolves when the server has taken it. */
  send: (wish: JogWish, expiryS: number) => Promise<unknown>;
  onEnd?: (why: JogEnd, error?: Error) => void;
  onChange?: (moving: boolean) => void;
  setTimer?: (callback: () => void, ms: number) => number;
  clearTimer?: (timer: number) => void;
}

export class Jog {
  private readonly held = new Map<string, JogWish>();
  private timer: number | null = null;
  private unanswered = 0;
  /** Answers to what was sent before this hold do not count for it. */
  private hold_ = 0;
  private stops_ = 0;

  constructor(private readonly options: JogOptions) {}

  get moving(): boolean {
    return this.held.size > 0;
  }
  /** What is moved. */
  get robot(): string | null {
    return this.sum()?.robot ?? null;
  }
  get sources(): string[] {
    return [...this.held.keys()];
  }
  /** How often everything had to let go: who waits to begin has to press anew when it has changed. */
  get stops(): number {
    return this.stops_;
  }

  /** A button, a key or a stick is held, or has changed its mind. */
  hold(source: string, wish: JogWish): void {
    for (const [other, held] of this.held) {
      if (held.robot !== wish.robot || held.frame !== wish.frame) this.held.delete(other);
    }
    const first = !this.moving;
    this.held.set(source, wish);
    if (!first) return;
    ++this.hold_;
    this.unanswered = 0;
    this.options.onChange?.(true);
    this.tick();
  }

  release(source: string): void {
    const wish = this.held.get(source);
    if (!wish) return;
    if (this.held.size === 1) return this.end('released');
    this.held.delete(source);
  }

  /** Everything lets go at once. */
  stop(why: JogEnd): void {
    ++this.stops_;
    if (this.moving) this.end(why);
  }

  private tick(): void {
    this.timer = null;
    const wish = this.sum();
    if (!wish) return;
    if (this.unanswered >= kJogUnansweredMax) return this.end('slow');
    this.post(wish);
    if (this.moving) this.timer = this.set(() => this.tick(), kJogIntervalMs);
  }

  private post(wish: JogWish): void {
    const hold = this.hold_;
    ++this.unanswered;
    this.options.send(wish, kJogExpiryS).then(
      () => {
        if (hold === this.hold_) --this.unanswered;
      },
      (error: Error) => {
        if (hold !== this.hold_ || !this.moving) return;
        this.end(error.name === 'Error' && 'code' in error ? 'refused' : 'lost', error);
      },
    );
  }

  private sum(): JogWish | null {
    const [first, ...others] = this.held.values();
    if (!first) return null;
    const velocity = first.velocity.map((value, i) =>
      others.reduce((all, other) => all + (other.velocity[i] ?? 0), value),
    );
    return { ...first, velocity };
  }

  private end(why: JogEnd, error?: Error): void {
    const wish = this.sum();
    this.held.clear();
    if (this.timer !== null) (this.options.clearTimer ?? clearTimeout)(this.timer);
    this.timer = null;
    ++this.hold_;
    if (wish && why !== 'lost') {
      const still = { ...wish, velocity: wish.velocity.map(() => 0) };
      this.options.send(still, kJogExpiryS).catch(() => undefined);
    }
    this.options.onChange?.(false);
    this.options.onEnd?.(why, error);
  }

  private set(callback: () => void, ms: number): number {
    return (this.options.setTimer ?? ((f, t) => setTimeout(f, t) as unknown as number))(
      callback,
      ms,
    );
  }
}

/** What of the page ends every hold. @return  takes it back */
export function watchPage(jog: Jog, view: Window, page: Document): () => void {
  const blur = () => jog.stop('blur');
  const hidden = () => {
    if (page.visibilityState !== 'visible') jog.stop('hidden');
  };
  view.addEventListener('blur', blur);
  view.addEventListener('pagehide', blur);
  page.addEventListener('visibilitychange', hidden);
  return () => {
    view.removeEventListener('blur', blur);
    view.removeEventListener('pagehide', blur);
    page.removeEventListener('visibilitychange', hidden);
  };
}

/** A velocity along one number of the frame, of its usual top speed. */
export function along(count: number, index: number, speed: number): number[] {
  return Array.from({ length: count }, (_, i) => (i === index ? speed : 0));
}
