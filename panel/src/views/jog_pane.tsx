import type { ComponentChildren, JSX } from 'preact';
import { useSignal } from '@preact/signals';
import { useEffect, useRef } from 'preact/hooks';
import { t } from '../i18n';
import { atWork, canMove, holdOnce, jog, jogging, model, robot, setPace, status, store } from '../app';
import { along } from '../logic/jog';
import { PadHold, padMode, padShares, padSticks, padStep, type PadMode } from '../logic/gamepad';
import { jogAxes, jogFrames, jogKey, stepRow, type JogAxis } from '../logic/jog_axes';
import { jointLimits, measuredOf } from '../logic/store';
import { isTextField } from '../logic/stop_keys';
import type { JogFrame, RobotModel } from '../logic/types';
import { clamp, shown, toRad, unitOf } from '../logic/units';
import { hoveredJoint } from '../scene_state';
import { FreeDrive } from './free_drive';
import { ReadyFirst } from './ready_first';
import { ToolKeys } from './tool_keys';
import { Icon, Segments, Slider, Toggle, useTimer } from './parts';

const kSteps = { length: ['0.1', '1', '10', '50'], angle: ['0.1', '1', '5', '15'] } as const;

const kTurnNames: Record<string, Parameters<typeof t>[0]> = {
  rx: 'jog.turn.x',
  ry: 'jog.turn.y',
  rz: 'jog.turn.z',
  pitch: 'jog.pitch',
  roll: 'jog.roll',
};
const axisText = (axis: JogAxis): string => {
  const key = kTurnNames[axis.name];
  return key ? t(key) : axis.name.length === 1 ? axis.name.toUpperCase() : axis.name;
};

interface Hand {
  frame: JogFrame;
  hold: boolean;
  share: number;
  length: number;
  angle: number;
}

/** By hand: while a button, a key or a stick is held, or step by step. */
export function JogPane(): JSX.Element {
  const one = model.value;
  const name = robot.value;
  const frame = useSignal<JogFrame>('joint');
  const wantsHold = useSignal(true);
  const share = useSignal(0.25);
  const length = useSignal('10');
  const angle = useSignal('5');
  if (!one || !name) return <p class="empty">{t('robot.pick')}</p>;
  const frames = jogFrames(one);
  const chosen = frames.includes(frame.value) ? frame.value : frames[0]!;
  const streams = Object.keys(one.jog).length > 0;
  const hand: Hand = {
    frame: chosen,
    hold: wantsHold.value && streams,
    share: share.value,
    length: Number(length.value) * 1e-3,
    angle: toRad(Number(angle.value)),
  };
  return (
    <div class="pane-body" data-tour="jog">
      <ReadyFirst />
      <FreeDrive />
      <Segments
        label={t('jog.frame')}
        value={chosen}
        options={frames.map((value) => ({ value, text: t(`jog.frame.${value}`) }))}
        onChange={(value) => (frame.value = value)}
      />
      {streams ? (
        <Segments
          label={t('jog.mode')}
          value={hand.hold ? 'hold' : 'step'}
          options={(['hold', 'step'] as const).map((value) => ({ value, text: t(`jog.mode.${value}`) }))}
          onChange={(value) => (wantsHold.value = value === 'hold')}
        />
      ) : (
        <p class="hint">{t('jog.whole_moves')}</p>
      )}
      {!hand.hold && (
        <div class="two">
          {(chosen !== 'joint' || one.kind === 'hexapod') && (
            <Segments
              label={t('jog.step.length')}
              value={length.value}
              options={kSteps.length.map((value) => ({ value: value as string, text: value }))}
              onChange={(value) => (length.value = value)}
            />
          )}
          {(chosen === 'joint' ? one.kind !== 'hexapod' : one.task !== 'point') && (
            <Segments
              label={t('jog.step.angle')}
              value={angle.value}
              options={kSteps.angle.map((value) => ({ value: value as string, text: value }))}
              onChange={(value) => (angle.value = value)}
            />
          )}
        </div>
      )}
      {chosen === 'joint' ? <JointRows model={one} hand={hand} /> : <ToolPad model={one} hand={hand} />}
      <Slider
        label={t('jog.speed')}
        value={share.value}
        min={0.02}
        max={1}
        step={0.01}
        text={`${Math.round(100 * share.value)} %`}
        onInput={(value) => (share.value = value)}
      />
      <ToolKeys model={one} name={name} />
      <Remote model={one} hand={hand} />
      <Pace />
      <p class="jog-live" role="status" data-on={jogging.value}>
        {jogging.value ? t('jog.moves') : ''}
      </p>
    </div>
  );
}

function Pace(): JSX.Element | null {
  const now = status.value;
  const one = model.value;
  const draft = useSignal<number | null>(null);
  if (!now || !one || !robot.value) return null;
  const most = Object.keys(one.jog).length > 0 ? 2 : 1;
  const value = draft.value ?? now.feed;
  return (
    <div
      class="pace"
      onPointerUp={() => (draft.value = null)}
      onKeyUp={() => (draft.value = null)}
    >
      <Slider
        label={t('jog.pace')}
        value={value}
        min={0}
        max={most}
        step={0.05}
        text={`${Math.round(100 * value)} %`}
        onInput={(share) => {
          draft.value = share;
          setPace(robot.value!, share);
        }}
      />
    </div>
  );
}

function stepOnce(name: string, model: RobotModel, hand: Hand, axis: JogAxis, sign: 1 | -1): void {
  const way = sign * (axis.measure === 'angle' ? hand.angle : hand.length);
  void store.run(name, stepRow(model, hand.frame, axis, way, hand.share), t('view.jog'));
}

/** Moves as long as it is held; in steps once a press. */
function HandButton(props: {
  axis: number;
  axes: JogAxis[];
  sign: 1 | -1;
  hand: Hand;
  model: RobotModel;
  children: ComponentChildren;
  class?: string;
}): JSX.Element {
  const { axis, axes, sign, hand } = props;
  const one = axes[axis]!;
  const source = `button ${hand.frame} ${one.name} ${sign}`;
  const enabled = canMove.value && (hand.hold || !atWork.value);
  const pressed = useRef(false);
  // What it holds keeps its name, whatever is chosen meanwhile.
  const held = useRef<string | null>(null);
  const begin = () => {
    const name = robot.value;
    if (!name || !enabled) return;
    pressed.current = true;
    held.current = source;
    if (hand.hold) {
      const velocity = along(axes.length, axis, sign * hand.share * one.speed);
      void holdOnce(source, { robot: name, frame: hand.frame, velocity }, () => pressed.current);
    } else {
      stepOnce(name, props.model, hand, one, sign);
    }
  };
  const end = () => {
    pressed.current = false;
    if (held.current !== null) jog.release(held.current);
    held.current = null;
  };
  // A button that is gone is let go: no browser tells it so.
  useEffect(() => end, []);
  // The button hears of it before the window does.
  const blur = () => {
    if (!document.hasFocus()) jog.stop('blur');
    end();
  };
  const text = t(sign > 0 ? 'jog.plus' : 'jog.minus', { name: axisText(one) });
  return (
    <button
      type="button"
      class={`hand ${props.class ?? ''}`}
      aria-label={text}
      title={text}
      disabled={!enabled}
      data-held={jogging.value && jog.sources.includes(source)}
      onPointerDown={(event) => {
        if (event.button !== 0) return;
        event.currentTarget.setPointerCapture(event.pointerId);
        begin();
      }}
      onPointerUp={end}
      onPointerCancel={end}
      onLostPointerCapture={end}
      onBlur={blur}
      onContextMenu={(event) => event.preventDefault()}
      onKeyDown={(event) => {
        if (event.key === 'Enter' && !event.repeat) begin();
      }}
      onKeyUp={(event) => {
        if (event.key === 'Enter') end();
      }}
    >
      {props.children}
    </button>
  );
}

function JointRows({ model: one, hand }: { model: RobotModel; hand: Hand }): JSX.Element {
  const axes = jogAxes(one, 'joint');
  return (
    <ul class="joint-rows">
      {one.joints.map((joint, i) => {
        const { lower, upper, measure } = jointLimits(joint);
        const now = status.value?.joints[i];
        const value = now ? measuredOf(now) : undefined;
        const share = value === undefined ? 50 : clamp((100 * (value - lower)) / (upper - lower), 0, 100);
        const near = share < 3 || share > 97;
        return (
          <li
            key={joint.name}
            onPointerEnter={() => (hoveredJoint.value = i)}
            onPointerLeave={() => (hoveredJoint.value = null)}
          >
            <HandButton axis={i} axes={axes} sign={-1} hand={hand} model={one}>
              −
            </HandButton>
            <div class="joint-face">
              <span class="joint-name">{joint.name}</span>
              <span class="joint-value">
                {value === undefined ? '–' : `${shown(value, measure)} ${unitOf(measure)}`}
                {near && value !== undefined && <em>{t('jog.limit')}</em>}
              </span>
              <span class="range" aria-hidden="true">
                <span class="range-zero" style={{ left: `${(100 * (0 - lower)) / (upper - lower)}%` }} hidden={lower > 0} />
                {value !== undefined && <span class={`range-at${near ? ' near' : ''}`} style={{ left: `${share}%` }} />}
              </span>
              <span class="range-ends" aria-hidden="true">
                <span>{shown(lower, measure, 0)}</span>
                <span>{shown(upper, measure, 0)}</span>
              </span>
            </div>
            <HandButton axis={i} axes={axes} sign={1} hand={hand} model={one}>
              +
            </HandButton>
          </li>
        );
      })}
    </ul>
  );
}

function ToolPad({ model: one, hand }: { model: RobotModel; hand: Hand }): JSX.Element {
  const axes = jogAxes(one, hand.frame);
  const button = (axis: number, sign: 1 | -1, text: string, place: string) => (
    <HandButton axis={axis} axes={axes} sign={sign} hand={hand} model={one} class={place}>
      {text}
    </HandButton>
  );
  return (
    <div class="tool-pad">
      <div class="pad-xyz">
        <div class="pad-xy">
          {button(1, 1, '+Y', 'n')}
          {button(0, -1, '−X', 'w')}
          <span class="pad-mid" aria-hidden="true">
            XY
          </span>
          {button(0, 1, '+X', 'e')}
          {button(1, -1, '−Y', 's')}
        </div>
        <div class="pad-z">
          {button(2, 1, '+Z', '')}
          <span class="pad-mid" aria-hidden="true">
            Z
          </span>
          {button(2, -1, '−Z', '')}
        </div>
      </div>
      {axes.length > 3 && (
        <ul class="turn-rows">
          {axes.slice(3).map((axis, i) => (
            <li key={axis.name}>
              {button(3 + i, -1, '−', '')}
              <span>{axisText(axis)}</span>
              {button(3 + i, 1, '+', '')}
            </li>
          ))}
        </ul>
      )}
    </div>
  );
}

/** What the sticks do now. */
const kPadLookMs = 20;

function padText(axes: JogAxis[], frame: JogFrame, joint: number, mode: PadMode, name: string): string {
  const text = (axis: number | undefined) => (axis === undefined ? '' : axisText(axes[axis]!));
  if (frame === 'joint') return t('jog.gamepad.joint', { joint: text(joint) });
  if (mode === 'rest') return t('jog.gamepad.rest', { name });
  const { across, up, lift, about } = padSticks(axes, frame, joint, mode);
  const left = `${text(across)}, ${text(up)}`;
  if (mode === 'move') return t('jog.gamepad.move', { left, right: text(lift) });
  return about === undefined ? t('jog.gamepad.left', { left }) : t('jog.gamepad.turn', { left, right: text(about) });
}

/** Keyboard and gamepad, each only while somebody has switched it on. */
function Remote({ model: one, hand }: { model: RobotModel; hand: Hand }): JSX.Element {
  const keyboard = useSignal(false);
  const gamepad = useSignal(false);
  const padName = useSignal<string | null>(null);
  const chosen = useSignal(0);
  const axes = jogAxes(one, hand.frame);
  // Another robot may have fewer.
  const joint = Math.min(chosen.value, axes.length - 1);
  const padIs = useSignal<PadMode>('rest');
  const padHold = useRef(new PadHold());
  const padStepped = useRef(0);
  const latest = useRef({ hand, axes, joint, of: one });
  latest.current = { hand, axes, joint, of: one };
  const choose = (i: number) => {
    chosen.value = i;
    hoveredJoint.value = i;
  };

  useEffect(() => {
    if (!keyboard.value) return;
    const keys = new Set<string>();
    const taken = (event: KeyboardEvent) => {
      const target = event.target as HTMLInputElement | null;
      const other = target?.tagName === 'SELECT' || (target?.tagName === 'INPUT' && target.type === 'range');
      return other || isTextField(target) || event.ctrlKey || event.metaKey || event.altKey;
    };
    const down = (event: KeyboardEvent) => {
      if (taken(event) || !canMove.value || !robot.value) return;
      const { hand: now, axes: all, joint: at, of } = latest.current;
      const digit = /^[1-9]$/.test(event.key) ? Number(event.key) - 1 : -1;
      if (now.frame === 'joint' && digit >= 0 && digit < all.length) {
        choose(digit);
        return;
      }
      const wish = jogKey(event.key, event.shiftKey, all, now.frame, at);
      if (!wish || !all[wish.axis]) return;
      event.preventDefault();
      if (event.repeat) return;
      const axis = all[wish.axis]!;
      if (!now.hold) {
        if (!atWork.value) stepOnce(robot.value, of, now, axis, wish.sign);
        return;
      }
      const speed = wish.sign * now.share * axis.speed;
      // By its place on the board: with Shift let go in between, what it writes is another key.
      keys.add(event.code);
      const velocity = along(all.length, wish.axis, speed);
      void holdOnce(`key ${event.code}`, { robot: robot.value, frame: now.frame, velocity }, () =>
        keys.has(event.code),
      );
    };
    const letGo = (code: string) => {
      keys.delete(code);
      jog.release(`key ${code}`);
    };
    const up = (event: KeyboardEvent) => {
      letGo(event.code);
      // While it is down some systems tell of no other key that is let go.
      if (event.key === 'Meta') for (const code of [...keys]) letGo(code);
    };
    const away = () => keys.clear();
    window.addEventListener('keydown', down);
    window.addEventListener('keyup', up);
    window.addEventListener('blur', away);
    return () => {
      away();
      window.removeEventListener('blur', away);
      window.removeEventListener('keydown', down);
      window.removeEventListener('keyup', up);
      jog.stop('released');
    };
  }, [keyboard.value]);

  // By a timer, as velocities are sent: a window that is drawn no more must not hold the last one.
  useTimer(gamepad.value && hand.hold, kPadLookMs, () => {
    const pad = navigator.getGamepads().find((one) => one?.connected && one.mapping === 'standard');
    padName.value = pad?.id.replace(/\s*\(.*$/, '') ?? null;
    padIs.value = pad ? padMode(pad) : 'rest';
    const hold = padHold.current;
    // A page without focus hears no keys either, and a Stop could not be pressed on it.
    if (!pad || !canMove.value || !robot.value || !document.hasFocus()) {
      hold.lose();
      return jog.release('gamepad');
    }
    const { hand: now, axes: all, joint: at } = latest.current;
    const shares = padShares(pad, all, now.frame, at);
    const step = padStep(pad);
    if (now.frame === 'joint' && !shares && step !== 0 && step !== padStepped.current) {
      choose((at + step + all.length) % all.length);
    }
    padStepped.current = step;
    const about = `${robot.value} ${now.frame}`;
    const held = jog.sources.includes('gamepad');
    const next = hold.look(shares !== null, held, about);
    if (!shares || next === 'rest') return jog.release('gamepad');
    const velocity = shares.map((share, i) => share * now.share * all[i]!.speed);
    const wish = { robot: robot.value, frame: now.frame, velocity };
    if (next === 'go_on') jog.hold('gamepad', wish);
    else if (next === 'begin') void holdOnce('gamepad', wish, () => hold.asks(about));
  });
  useEffect(() => {
    if (!gamepad.value || !hand.hold) return;
    const hold = padHold.current;
    const end = () => {
      hold.lose();
      jog.release('gamepad');
    };
    window.addEventListener('gamepaddisconnected', end);
    return () => {
      window.removeEventListener('gamepaddisconnected', end);
      end();
    };
  }, [gamepad.value, hand.hold]);
  // Nothing of the scene is marked any more where nobody jogs.
  useEffect(() => () => void (hoveredJoint.value = null), []);

  return (
    <div class="remote">
      <div class="row">
        <Toggle pressed={keyboard.value} onChange={(on) => (keyboard.value = on)}>
          <Icon name="keyboard" /> {t('jog.keyboard')}
        </Toggle>
        {hand.hold && (
          <Toggle pressed={gamepad.value} onChange={(on) => (gamepad.value = on)}>
            <Icon name="gamepad" /> {t('jog.gamepad')}
          </Toggle>
        )}
      </div>
      {keyboard.value && (
        <p class="hint">
          {hand.frame === 'joint'
            ? `${t('jog.keyboard.help.joint', { count: axes.length })} (${axes[joint]?.name ?? ''})`
            : t('jog.keyboard.help.tool')}
          {!hand.hold && ` ${t('jog.keyboard.steps')}`}
        </p>
      )}
      {gamepad.value && hand.hold && (
        <p class="hint">
          {padName.value ? padText(axes, hand.frame, joint, padIs.value, padName.value) : t('jog.gamepad.none')}
        </p>
      )}
    </div>
  );
}
