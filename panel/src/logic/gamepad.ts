/**
 * Jogging by a gamepad in the standard mapping. One of two shoulder buttons has to be held (the dead
 * man's switch): with the left one the sticks move, with the right one they turn; with both, or
 * neither, nothing does.
 */
import { turnKeys, type JogAxis } from './jog_axes';
import type { JogFrame } from './types';

export interface Pad {
  axes: readonly number[];
  buttons: readonly { pressed: boolean }[];
}

export type PadMode = 'rest' | 'move' | 'turn';

/** Places in the standard mapping. */
const kShoulders = { left: 4, right: 5 } as const;
const kCross = { up: 12, down: 13, left: 14, right: 15 } as const;
const kDead = 0.16;

/** Beyond the dead zone from 0, finer near it. */
export function stick(value: number): number {
  const beyond = Math.abs(value) - kDead;
  if (!(beyond > 0)) return 0;
  return Math.sign(value) * Math.min(1, beyond / (1 - kDead)) ** 1.6;
}

const pressed = (pad: Pad, button: number): boolean => pad.buttons[button]?.pressed ?? false;

export function padMode(pad: Pad): PadMode {
  const left = pressed(pad, kShoulders.left);
  const right = pressed(pad, kShoulders.right);
  if (left === right) return 'rest';
  return left ? 'move' : 'turn';
}

/** Which number of a jog each stick stands for; a pad's own y counts down. */
export interface PadSticks {
  /** Left stick to the right. */
  across?: number;
  /** Left stick up. */
  up?: number;
  /** Right stick up. */
  lift?: number;
  /** Right stick to the left: counterclockwise, as turns count. */
  about?: number;
}

export function padSticks(axes: readonly JogAxis[], frame: JogFrame, joint: number, mode: PadMode): PadSticks {
  if (mode === 'rest') return {};
  if (frame === 'joint') return { across: joint };
  return mode === 'move' ? { across: 0, up: 1, lift: 2 } : turnKeys(axes);
}

/** What a pad asks for, as shares of full speed; nothing where it is let go or in its middle. */
export function padShares(pad: Pad, axes: readonly JogAxis[], frame: JogFrame, joint: number): number[] | null {
  const { across, up, lift, about } = padSticks(axes, frame, joint, padMode(pad));
  const [leftX = 0, leftY = 0, rightX = 0, rightY = 0] = pad.axes;
  const shares = axes.map((_, i) => {
    if (i === across) return stick(leftX);
    if (i === up) return stick(-leftY);
    if (i === lift) return stick(-rightY);
    return i === about ? stick(-rightX) : 0;
  });
  return shares.some((one) => one !== 0) ? shares : null;
}

/** Which joint the cross wishes for, counted from the chosen one. */
export function padStep(pad: Pad): -1 | 0 | 1 {
  const back = pressed(pad, kCross.up) || pressed(pad, kCross.left);
  const on = pressed(pad, kCross.down) || pressed(pad, kCross.right);
  if (back === on) return 0;
  return on ? 1 : -1;
}

/**
 * A pad is looked at, it tells nothing by itself: what was begun with it may have been ended by Stop, a
 * refusal or another robot meanwhile. It has to be let go then before it moves anything again.
 *
 *            wished                 held
 *   rest ---------------> asked ------------> moving
 *    ^                      |  other robot, frame   | .. or not held any more
 *    |       let go         v                       v
 *    +------------------- spent <-------------------+
 */
export class PadHold {
  private phase: 'rest' | 'asked' | 'moving' | 'spent' = 'spent';
  private about = '';

  /** It is gone, or nothing may move: all begins with letting go. */
  lose(): void {
    this.phase = 'spent';
  }

  /** Whether what was asked for then is still wished for. */
  asks(about: string): boolean {
    return this.phase === 'asked' && this.about === about;
  }

  /**
   * @param about  the robot and the frame that are meant
   * @param held  what it began goes on
   */
  look(wished: boolean, held: boolean, about: string): 'rest' | 'begin' | 'wait' | 'go_on' {
    if (!wished) {
      this.phase = 'rest';
      return 'rest';
    }
    const other = about !== this.about && this.phase !== 'rest';
    if (other || this.phase === 'spent' || (this.phase === 'moving' && !held)) {
      this.phase = 'spent';
      this.about = about;
      return 'rest';
    }
    this.about = about;
    if (held) {
      this.phase = 'moving';
      return 'go_on';
    }
    if (this.phase === 'asked') return 'wait';
    this.phase = 'asked';
    return 'begin';
  }
}
