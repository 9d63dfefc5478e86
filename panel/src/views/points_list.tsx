import type { JSX } from 'preact';
import { useEffect, useRef, useState } from 'preact/hooks';
import { t } from '../i18n';
import { atWork, canMove, model, way } from '../app';
import { kPointName, poseOf, type NotTaught, type Point } from '../logic/points';
import { shown, unitOf, type Measure } from '../logic/units';
import { goThere, going, head, measuresOf, removePoint, renamePoint, retake, shelf, stay, take } from '../teach';
import type { RobotModel } from '../logic/types';
import { FileButtons } from './file_buttons';
import { FreeDrive } from './free_drive';
import { Icon } from './parts';
import { ProgramVerdictCard } from './program_verdict';
import { Thumbnail } from './thumbnail';
import { WaySpeed } from './way_speed';

/** One unit behind all values that have it. */
const jointsText = (joints: readonly number[], measures: readonly Measure[]): string =>
  joints
    .map((value, i) => {
      const measure = measures[i] ?? 'angle';
      return shown(value, measure) + (measures[i + 1] === measure ? '' : ` ${unitOf(measure)}`);
    })
    .join('  ');

/** Where the arm was when somebody said: here. */
export function PointsList(): JSX.Element {
  const one = model.value!;
  const [wish, setWish] = useState('');
  const [trouble, setTrouble] = useState<string | null>(null);
  const { points } = shelf.value;
  const bad = wish !== '' && !kPointName.test(wish);
  const tell = (result: { wrong: NotTaught; joint?: string } | Point | null): boolean => {
    const wrong = result && 'wrong' in result ? result : null;
    setTrouble(wrong ? t(`pts.not.${wrong.wrong}`, { joint: wrong.joint ?? '' }) : null);
    return !wrong;
  };
  return (
    <>
      <FreeDrive />
      <form
        class="take"
        onSubmit={(event) => {
          event.preventDefault();
          if (!bad && tell(take(wish || 'point1'))) setWish('');
        }}
      >
        <label class="text-field">
          <span class="field-label">{t('pts.name')}</span>
          <input
            type="text"
            value={wish}
            placeholder="point1"
            maxLength={40}
            aria-invalid={bad}
            onInput={(event) => setWish(event.currentTarget.value)}
          />
        </label>
        <button type="submit" class="primary" disabled={bad} data-tour="take">
          <Icon name="pin" /> {t('pts.take')}
        </button>
        <FileButtons kind="points" />
      </form>
      {bad && <p class="wrong-words">{t('pts.name.rule')}</p>}
      {trouble && (
        <p class="wrong-words" role="alert">
          {trouble}
        </p>
      )}
      {points.length > 0 && (
        <WaySpeed
          model={one}
          onInput={(speed) => {
            way.value = { ...way.value, speed };
            const now = points.find((point) => point.name === going.value?.point);
            if (now) head(now);
          }}
        />
      )}
      {points.length === 0 ? (
        <p class="empty">{t('pts.none')}</p>
      ) : (
        <ul class="points">
          {points.map((point) => (
            <PointCard key={point.name} point={point} model={one} onRetake={() => tell(retake(point.name))} />
          ))}
        </ul>
      )}
    </>
  );
}

function PointCard(props: { point: Point; model: RobotModel; onRetake: () => void }): JSX.Element {
  const { point, model: one } = props;
  const [draft, setDraft] = useState<string | null>(null);
  const [sure, setSure] = useState<'remove' | 'retake' | null>(null);
  const pose = poseOf(point, one);
  const now = going.value?.point === point.name ? going.value : null;
  const taken = shelf.value.points.some((other) => other !== point && other.name === draft);
  const fits = draft !== null && kPointName.test(draft) && !taken;
  return (
    <li class={`point${now ? ' chosen' : ''}`}>
      {point.joints || point.place ? (
        <Thumbnail model={one} joints={point.joints} platform={point.platform} place={point.place} />
      ) : (
        <span class="thumb-none" aria-hidden="true">
          <Icon name="pin" size={28} />
        </span>
      )}
      <div class="point-what">
        {draft === null ? (
          <h4 title={point.source}>{point.name}</h4>
        ) : (
          <input
            type="text"
            class={`rename${fits || draft === point.name ? '' : ' wrong'}`}
            value={draft}
            aria-label={t('pts.rename', { name: point.name })}
            aria-invalid={!fits && draft !== point.name}
            ref={(input) => input?.focus()}
            onInput={(event) => setDraft(event.currentTarget.value)}
            onBlur={() => {
              if (fits) renamePoint(point.name, draft);
              setDraft(null);
            }}
            onKeyDown={(event) => {
              if (event.key === 'Enter') event.currentTarget.blur();
            }}
          />
        )}
        {pose && (
          <p>
            {pose.slice(0, 3).map((one) => shown(one, 'length')).join('  ')} mm
            {pose.length > 3 && <span class="muted">{'  '}{pose.slice(3).map((one) => shown(one, 'angle')).join('  ')} °</span>}
          </p>
        )}
        {point.joints && (
          <p class="muted">
            {jointsText(point.joints, measuresOf(one))}
          </p>
        )}
      </div>
      <div class="point-do">
        <button type="button" onClick={() => (now ? stay() : head(point))} aria-pressed={!!now}>
          {t(now ? 'pts.stay' : 'pts.go')}
        </button>
        <span class="row tight">
          <IconButton icon="pen" label={t('pts.rename', { name: point.name })} onClick={() => setDraft(point.name)} />
          <IconButton icon="pin" label={t('pts.retake', { name: point.name })} onClick={() => setSure('retake')} />
          <IconButton icon="trash" label={t('pts.remove', { name: point.name })} onClick={() => setSure('remove')} />
        </span>
      </div>
      {sure && (
        <Sure
          text={t(sure === 'remove' ? 'pts.remove' : 'pts.retake', { name: point.name })}
          onYes={() => (sure === 'remove' ? removePoint(point.name) : props.onRetake())}
          onEnd={() => setSure(null)}
        />
      )}
      {now && (
        <div class="point-way">
          <ProgramVerdictCard verdict={now.verdict} />
          <button
            type="button"
            class="primary big"
            data-tour="point-go"
            disabled={now.verdict.kind !== 'fine' || !canMove.value || atWork.value}
            onClick={() => void goThere()}
          >
            {t(atWork.value ? 'move.going' : 'move.go')}
          </button>
        </div>
      )}
    </li>
  );
}

/** What is kept for all is changed for all: asked once more, where it stands. */
export function Sure(props: { text: string; no?: string; onYes: () => void; onEnd: () => void }): JSX.Element {
  const yes = useRef<HTMLButtonElement>(null);
  useEffect(() => yes.current?.focus(), []);
  return (
    <div class="row sure">
      <button
        type="button"
        class="grave"
        ref={yes}
        onClick={() => {
          props.onYes();
          props.onEnd();
        }}
      >
        {props.text}
      </button>
      <button type="button" class="quiet" onClick={props.onEnd}>
        {props.no ?? t('sure.no')}
      </button>
    </div>
  );
}

export function IconButton(props: {
  icon: Parameters<typeof Icon>[0]['name'];
  label: string;
  onClick: () => void;
  disabled?: boolean;
}): JSX.Element {
  return (
    <button type="button" class="quiet icon-button" title={props.label} aria-label={props.label} disabled={props.disabled} onClick={props.onClick}>
      <Icon name={props.icon} size={16} />
    </button>
  );
}
