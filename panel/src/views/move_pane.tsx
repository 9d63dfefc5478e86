import type { JSX } from 'preact';
import { refusalSentence, t, tWord } from '../i18n';
import {
  aim,
  atWork,
  canMove,
  forgetTarget,
  gizmoMode,
  model,
  move,
  robot,
  setWay,
  standing,
  status,
  target,
  verdict,
  way,
} from '../app';
import { toolPose } from '../logic/kinematics';
import { fromFixedXyz, fromJson } from '../logic/pose';
import { jointLimits, jointsOf, measuredOf } from '../logic/store';
import { canTurn, toolNumbers, withJoint, withTool, type Target } from '../logic/target';
import type { RobotModel, Vec3 } from '../logic/types';
import { clamp, decimals, duration, toMm } from '../logic/units';
import { hoveredJoint } from '../scene_state';
import { Icon, NumberField, Segments } from './parts';
import { ReadyFirst } from './ready_first';
import { ToolKeys } from './tool_keys';
import { WaySpeed } from './way_speed';

/** Seen first, moved then: a target, the ghost that stands there, and what the server says to it. */
export function MovePane(): JSX.Element {
  const one = model.value;
  if (!one || !robot.value) return <p class="empty">{t('robot.pick')}</p>;
  const here = standing();
  if (!here) return <p class="empty">{t('move.unknown')}</p>;
  const now = target.value ?? here;
  return (
    <div class="pane-body" data-tour="move">
      <ReadyFirst />
      <JointSliders model={one} now={now} />
      <ToolFields model={one} now={now} />
      <div class="two">
        <Segments
          label={t('move.way')}
          value={way.value.line ? 'line' : 'joints'}
          options={(['joints', 'line'] as const).map((value) => ({ value, text: t(`move.way.${value}`) }))}
          onChange={(value) => setWay({ ...way.value, line: value === 'line' })}
        />
        {canTurn(one) && (
          <Segments
            label={t('move.gizmo')}
            value={gizmoMode.value}
            options={(['translate', 'rotate'] as const).map((value) => ({ value, text: t(`move.gizmo.${value}`) }))}
            onChange={(value) => (gizmoMode.value = value)}
          />
        )}
      </div>
      <ToolKeys model={one} name={robot.value!} />
      <WaySpeed model={one} onInput={(speed) => setWay({ ...way.value, speed })} />
      <div class="pane-foot">
        <VerdictCard model={one} />
        <div class="row">
          <button type="button" onClick={() => aim(homeTarget(one, now))}>
            <Icon name="home" /> {t('move.home')}
          </button>
          <button type="button" disabled={!target.value} onClick={forgetTarget} title={t('move.reset')}>
            <Icon name="reset" />
            <span class="sr-only">{t('move.reset')}</span>
          </button>
          <button
            type="button"
            class="primary big"
            data-tour="go"
            disabled={!target.value || verdict.value.kind !== 'fine' || !canMove.value || atWork.value}
            onClick={() => void move()}
          >
            {t(atWork.value ? 'move.going' : 'move.go')}
          </button>
        </div>
      </div>
    </div>
  );
}

function homeTarget(one: RobotModel, now: Target): Target {
  const joints = one.joints.map((joint) => jointLimits(joint).home);
  const tool = one.kind === 'hexapod' ? fromJson(one.geometry.home) : toolPose(one, joints);
  return { ...now, by: 'joints', joints, tool, turned: false };
}

function JointSliders({ model: one, now }: { model: RobotModel; now: Target }): JSX.Element {
  const measured = jointsOf(status.value, measuredOf);
  const judged = verdict.value;
  const blamed = target.value && judged.kind === 'refused' ? judged.data?.joint : undefined;
  return (
    <fieldset class="joints">
      <legend>{t('move.joints')}</legend>
      {one.joints.map((joint, i) => {
        const { lower, upper, measure } = jointLimits(joint);
        const value = now.joints[i] ?? 0;
        const share = (100 * (value - lower)) / (upper - lower);
        const stands = measured ? clamp((100 * (measured[i]! - lower)) / (upper - lower), 0, 100) : null;
        const change = (wish: number) => aim(withJoint(now, one, i, wish));
        return (
          <div
            class={`joint-slider${blamed === joint.name ? ' blamed' : ''}`}
            key={joint.name}
            onPointerEnter={() => (hoveredJoint.value = i)}
            onPointerLeave={() => (hoveredJoint.value = null)}
            onFocusIn={() => (hoveredJoint.value = i)}
            onFocusOut={() => (hoveredJoint.value = null)}
          >
            <span class="joint-name">{joint.name}</span>
            <span class="track">
              <input
                type="range"
                class="slider"
                aria-label={joint.name}
                min={lower}
                max={upper}
                step={(upper - lower) / 1000}
                value={value}
                style={{ '--share': `${share}%` } as JSX.CSSProperties}
                onInput={(event) => change(Number(event.currentTarget.value))}
              />
              {stands !== null && <span class="stands" style={{ left: `${stands}%` }} aria-hidden="true" />}
            </span>
            <NumberField
              label={t('move.value', { name: joint.name })}
              value={value}
              measure={measure}
              onCommit={change}
            />
          </div>
        );
      })}
    </fieldset>
  );
}

function ToolFields({ model: one, now }: { model: RobotModel; now: Target }): JSX.Element {
  const numbers = toolNumbers(now.tool);
  const turns = canTurn(one);
  const change = (i: number, value: number) => {
    const next = [...numbers] as typeof numbers;
    next[i] = value;
    const p: Vec3 = [next[0], next[1], next[2]];
    const q = i < 3 ? now.tool.q : fromFixedXyz([next[3], next[4], next[5]]);
    aim(withTool(now, { p, q }));
  };
  return (
    <fieldset class="tool-fields" title={t('move.convention')}>
      <legend>{t('move.tool')}</legend>
      {(['X', 'Y', 'Z', 'Rx', 'Ry', 'Rz'] as const).map((name, i) => (
        <label key={name}>
          <span>{name}</span>
          <NumberField
            label={t('move.value', { name })}
            value={numbers[i]!}
            measure={i < 3 ? 'length' : 'angle'}
            readOnly={i > 2 && (!turns || (one.task === 'yaw' && i < 5))}
            onCommit={(value) => change(i, value)}
          />
        </label>
      ))}
    </fieldset>
  );
}

/** What the server says to the target. */
function VerdictCard({ model: one }: { model: RobotModel }): JSX.Element {
  const now = verdict.value;
  if (!target.value) {
    return <p class="verdict ask">{t(atWork.value ? 'move.busy' : 'move.ask')}</p>;
  }
  if (now.kind === 'checking') return <p class="verdict checking">{t('move.checking')} …</p>;
  if (now.kind === 'lost') return <p class="verdict checking">{t('connection.lost')}</p>;
  if (now.kind === 'fine') {
    const { preview } = now;
    const limited = preview.limited;
    return (
      <div class="verdict fine" role="status">
        <p class="verdict-head">
          <Icon name={preview.first_move ? 'fault' : 'check'} />
          {t(preview.first_move ? 'move.unchecked' : 'move.fine')}
          <strong>{duration(preview.duration_s)}</strong>
        </p>
        {preview.first_move ? (
          <p>{t('move.first')}</p>
        ) : (
          limited && <p>{tWord('move.limited', limited.by, { joint: limited.joint ?? '' })}</p>
        )}
      </div>
    );
  }
  const offer = now.data?.would_work;
  return (
    <div class="verdict refused" role="status">
      <p class="verdict-head">
        <Icon name="fault" /> {t('move.refused')}
        {now.data?.share !== undefined && now.data.share > 0 && now.data.share < 1 && (
          <span>{t('move.at', { percent: Math.round(100 * now.data.share) })}</span>
        )}
      </p>
      <p>{refusalSentence({ message: now.sentence, data: now.data })}</p>
      {offer && (
        <>
          <p>{tWord('move.instead', offer.what, { mm: decimals(toMm(offer.left_m ?? 0), 1) })}</p>
          <button
            type="button"
            onClick={() => {
              const next = target.value!;
              const tool = one.kind === 'hexapod' ? next.tool : toolPose(one, offer.positions);
              setWay({ ...way.value, line: false });
              aim({ ...next, by: 'joints', joints: offer.positions, tool, turned: false });
            }}
          >
            {t('move.instead')}
          </button>
        </>
      )}
    </div>
  );
}
