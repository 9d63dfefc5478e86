import type { JSX } from 'preact';
import { complaintSentence, errorSentence, t, type Key } from '../i18n';
import { model, robot, store } from '../app';
import {
  askToLeave,
  begin,
  busy,
  calibration,
  chosenMark,
  drop,
  goTo,
  leave,
  leaving,
  mark,
  paper,
  pin,
  print,
  said,
  save,
  saved,
  sheetStays,
  take,
  touch,
  unsaved,
  views,
  wizardStep,
  type Paper,
  type WizardStep,
} from '../calibration_state';
import { camera, picture, shot } from '../camera_state';
import { kSheetTags, residualShare } from '../logic/calibration';
import type { CalibrationView, TouchJson } from '../logic/types';
import { clamp, decimals } from '../logic/units';
import { JogPane } from './jog_pane';
import { Icon, NumberField, Segments } from './parts';

const kSteps: readonly WizardStep[] = ['print', 'board', 'sheet', 'touch', 'result'];
const outline = (corners: readonly (readonly number[])[]): string => corners.map((p) => p.join(',')).join(' ');
const viewer = (): boolean => store.role.value === 'viewer';

/** Lens and pose of a camera, from views of a printed board: what to do, step by step. */
export function CalibrationWizard(): JSX.Element {
  const step = wizardStep.value;
  return (
    <section class="calibrate" aria-label={t('cal.title', { camera: camera.value?.name ?? '' })}>
      <header class="calibrate-head">
        <h3>{t('cal.title', { camera: camera.value?.name ?? '' })}</h3>
        <button type="button" class="quiet icon-only" aria-label={t('cal.leave')} title={t('cal.leave')} onClick={askToLeave}>
          <Icon name="close" />
        </button>
      </header>
      {leaving.value && <Leaving />}
      {saved.value ? (
        <Saved />
      ) : (
        <>
          <Steps now={step} />
          {step === 'print' && <Print />}
          {step === 'board' && <Board />}
          {step === 'sheet' && <Sheet />}
          {step === 'touch' && <Touch />}
          {step === 'result' && <Result />}
        </>
      )}
    </section>
  );
}

function Leaving(): JSX.Element {
  return (
    <div class="callout" role="alertdialog" aria-label={t('cal.leave')}>
      <p>{unsaved.value > 0 ? t('cal.leave.unsaved', { count: unsaved.value }) : t('cal.leave.empty')}</p>
      <div class="row">
        <button type="button" class="primary" onClick={() => (leaving.value = false)}>
          {t('cal.leave.stay')}
        </button>
        <button type="button" onClick={() => void leave(false)}>
          {t('cal.leave.later')}
        </button>
        <button type="button" disabled={viewer()} onClick={() => void leave(true)}>
          <Icon name="trash" /> {t('cal.leave.discard')}
        </button>
      </div>
    </div>
  );
}

/** Which steps can be gone to. */
function isOpen(step: WizardStep): boolean {
  const now = calibration.value;
  if (step === 'print' || step === 'board') return true;
  const enough = views.value.length >= (now?.views_least ?? 5);
  return step === 'sheet' ? enough : enough && now?.sheet !== undefined;
}

function Steps({ now }: { now: WizardStep }): JSX.Element {
  const place = kSteps.indexOf(now);
  return (
    <ol class="calibrate-steps">
      {kSteps.map((step, i) => (
        <li key={step} class={i < place ? 'done' : ''}>
          <button
            type="button"
            aria-current={step === now ? 'step' : undefined}
            disabled={busy.value || viewer() || !isOpen(step)}
            onClick={() => void goTo(step)}
          >
            <span class="calibrate-number" aria-hidden="true">
              {i < place ? <Icon name="check" size={13} /> : i + 1}
            </span>
            {t(`cal.step.${step}` as Key)}
          </button>
        </li>
      ))}
    </ol>
  );
}

function Print(): JSX.Element {
  const otherPaper = unsaved.value > 0 && calibration.value?.paper !== paper.value;
  return (
    <>
      <p>{t('cal.print.how')}</p>
      <Segments
        label={t('cal.paper')}
        value={paper.value}
        options={(['a4', 'a3', 'letter'] as const).map((value: Paper) => ({ value, text: t(`cal.paper.${value}` as Key) }))}
        onChange={(value) => (paper.value = value)}
      />
      <div class="calibrate-prints">
        {(['board', 'sheet'] as const).map((what) => (
          <section key={what}>
            <h4>{t(`cal.print.${what}` as Key)}</h4>
            <p class="hint">{t(`cal.print.${what}.how` as Key)}</p>
            <div class="row">
              {(['pdf', 'svg'] as const).map((form) => (
                <button
                  key={form}
                  type="button"
                  aria-label={t('cal.print.form', { what: t(`cal.print.${what}` as Key), form: form.toUpperCase() })}
                  onClick={() => void print(what, form)}
                >
                  <Icon name="save" /> {form.toUpperCase()}
                </button>
              ))}
            </div>
          </section>
        ))}
      </div>
      <p class="hint">{t('cal.print.ruler')}</p>
      {calibration.value?.simulated && <p class="hint">{t('cal.simulated')}</p>}
      {otherPaper && <p class="calibrate-trouble">{t('cal.print.anew', { count: unsaved.value })}</p>}
      <Told />
      <button type="button" class="primary big" disabled={busy.value || viewer()} onClick={() => void begin()}>
        {t('cal.print.next')} <Icon name="later" />
      </button>
    </>
  );
}

function Board(): JSX.Element {
  const now = calibration.value;
  const enough = now?.views_enough ?? 8;
  const least = now?.views_least ?? 5;
  const count = views.value.length;
  return (
    <>
      <p class="hint">{t('cal.board.how')}</p>
      <Live />
      <div class="calibrate-progress">
        <span
          class="bar"
          role="progressbar"
          aria-label={t('cal.views')}
          aria-valuemin={0}
          aria-valuemax={enough}
          aria-valuenow={Math.min(count, enough)}
        >
          <span style={{ width: `${Math.min(100, (100 * count) / enough)}%` }} />
        </span>
        <span>{t(count >= enough ? 'cal.views.enough' : 'cal.views.count', { count, enough })}</span>
      </div>
      <Told />
      {now?.better && (
        <p class="calibrate-better">
          <Icon name="eye" size={16} /> {complaintSentence(now.better)}
        </p>
      )}
      <div class="row">
        <button type="button" class={count < enough ? 'primary big' : 'big'} disabled={busy.value || viewer()} onClick={() => void take()}>
          <Icon name="eye" /> {t(busy.value ? 'cal.taking' : 'cal.take')}
        </button>
        <button type="button" class={count < enough ? 'big' : 'primary big'} disabled={busy.value || viewer() || count < least} onClick={() => void goTo('sheet')}>
          {t('cal.board.next')} <Icon name="later" />
        </button>
      </div>
      {now?.trouble && <p class="calibrate-trouble">{complaintSentence(now.trouble)}</p>}
      <Views />
    </>
  );
}

function Sheet(): JSX.Element {
  return (
    <>
      <p class="hint">{t(calibration.value?.simulated ? 'cal.sheet.simulated' : 'cal.sheet.how')}</p>
      <Live />
      <Told />
      <button type="button" class="primary big" disabled={busy.value || viewer()} onClick={() => void take()}>
        <Icon name="eye" /> {t(busy.value ? 'cal.taking' : 'cal.sheet.take')}
      </button>
    </>
  );
}

/** What the camera sees now: tags that are found, over the parts of the picture that views have shown. */
function Live(): JSX.Element {
  const now = shot.value;
  if (!now?.width_px || !picture.value) return <p class="camera-waits">{t('camera.waits')}</p>;
  const { width_px: width, height_px: height = 1 } = now;
  const rows = wizardStep.value === 'board' ? (calibration.value?.coverage ?? []) : [];
  const ofSheet = wizardStep.value === 'sheet';
  const tags = (now.tags ?? []).filter((tag) => kSheetTags.has(tag.id) === ofSheet);
  const gone = now.fault && (now.fault.code === 'camera_lost' || now.fault.code === 'camera_blind' || now.fault.code === 'camera_frozen');
  return (
    <>
      {gone && (
        <p class="calibrate-trouble" role="alert">
          {errorSentence(now.fault!)}
        </p>
      )}
      <div class={`camera-picture${gone ? ' stale' : ''}`} style={{ aspectRatio: `${width} / ${height}` }}>
        <img src={picture.value} alt={t('camera.picture')} />
        <svg viewBox={`0 0 ${width} ${height}`} aria-hidden="true">
          {rows.flatMap((row, r) =>
            row.map((seen, c) => (
              <rect
                key={`${r}.${c}`}
                class={`calibrate-cell${seen ? ' seen' : ''}`}
                x={(c * width) / row.length}
                y={(r * height) / rows.length}
                width={width / row.length}
                height={height / rows.length}
                stroke-width={width / 640}
              />
            )),
          )}
          {tags.map((tag) => (
            <polygon key={tag.id} class="calibrate-tag" points={outline(tag.corners_px)} stroke-width={Math.max(2, width / 260)} />
          ))}
        </svg>
        <span class={`calibrate-found${tags.length > 0 ? ' some' : ''}`}>{t('cal.found', { count: tags.length })}</span>
      </div>
    </>
  );
}

function Told(): JSX.Element {
  const now = said.value;
  return (
    <p class={`calibrate-told${now ? ` ${now.kind}` : ''}`} role="status">
      {now && (
        <>
          <Icon name={now.kind === 'taken' ? 'check' : 'fault'} size={16} />{' '}
          {now.text}
        </>
      )}
    </p>
  );
}

function Views(): JSX.Element | null {
  const now = calibration.value;
  if (views.value.length === 0) return null;
  return (
    <ul class="calibrate-views" aria-label={t('cal.views')}>
      {views.value.map((view) => (
        <li key={view.view}>
          <Small view={view} width={now?.width_px ?? 4} height={now?.height_px ?? 3} />
          <span class="calibrate-view-name">{t('cal.view', { view: view.view })}</span>
          <span class="muted">{t('cal.view.tags', { count: view.tags })}</span>
          {view.residual_px !== undefined && (
            <span class="calibrate-residual" title={t('cal.view.residual')}>
              <span style={{ width: `${100 * residualShare(view.residual_px)}%` }} class={residualShare(view.residual_px) > 0.75 ? 'poor' : ''} />
              <b>{decimals(view.residual_px, 2)} px</b>
            </span>
          )}
          <Delete what={{ view: view.view }} label={t('cal.view.delete', { view: view.view })} />
        </li>
      ))}
    </ul>
  );
}

function Delete({ what, label }: { what: Parameters<typeof drop>[0]; label: string }): JSX.Element {
  return (
    <button type="button" class="quiet icon-only" aria-label={label} title={label} disabled={busy.value || viewer()} onClick={() => void drop(what)}>
      <Icon name="trash" size={16} />
    </button>
  );
}

/** The tip of a robot's tool is brought onto marks of the sheet: so it reaches what the camera sees. */
function Touch(): JSX.Element {
  const now = calibration.value;
  const touched = now?.touch;
  const name = robot.value;
  const hasTip = model.value !== null && model.value.kind !== 'hexapod';
  return (
    <>
      <p class="hint">{t('cal.touch.how', { robot: name ?? '' })}</p>
      <Marks />
      <label class="calibrate-pin">
        {t('cal.touch.pin')}{' '}
        <NumberField
          label={t('cal.touch.pin')}
          value={pin.value}
          measure="length"
          disabled={viewer()}
          onCommit={(value) => (pin.value = clamp(value, 0, 0.3))}
        />
      </label>
      <Told />
      <button
        type="button"
        class="primary big"
        disabled={busy.value || viewer() || !name || !hasTip || !mark.value || pin.value <= 0}
        onClick={() => void touch(name!)}
      >
        <Icon name="check" /> {t('cal.touch.take', { mark: mark.value ?? '' })}
      </button>
      {!hasTip && <p class="calibrate-trouble">{t('cal.touch.no_tip')}</p>}
      {touched?.trouble && !touched.too_few && <p class="calibrate-trouble begins">{complaintSentence(touched.trouble)}.</p>}
      {touched?.error_m !== undefined && <TouchFigures touched={touched} />}
      <button type="button" class="big" disabled={busy.value} onClick={() => void goTo('result')}>
        {t(touched ? 'cal.touch.next' : 'cal.touch.skip')} <Icon name="later" />
      </button>
      {!touched && <p class="hint">{t('cal.touch.skipped')}</p>}
      <section class="calibrate-jog" aria-label={t('view.jog')}>
        <JogPane />
      </section>
    </>
  );
}

function TouchFigures({ touched }: { touched: TouchJson }): JSX.Element {
  return (
    <>
      <dl class="calibrate-facts">
        <dt>{t('cal.touch.error')}</dt>
        <dd>{decimals(1000 * touched.error_m!, 1)} mm</dd>
        <dt>{t('cal.touch.rms')}</dt>
        <dd>{decimals(1000 * (touched.rms_m ?? 0), 2)} mm</dd>
        <dt>{t('cal.touch.moved')}</dt>
        <dd>{decimals(1000 * (touched.moved_m ?? 0), 1)} mm</dd>
      </dl>
      {touched.next && touched.next.error_m < 0.8 * touched.error_m! && (
        <p class="calibrate-better">
          <Icon name="eye" size={16} />{' '}
          {t('cal.touch.better', { mark: touched.next.mark, mm: decimals(1000 * touched.next.error_m, 1) })}
        </p>
      )}
    </>
  );
}

/** Arrows go to the mark before or behind, as in any radio group. */
function chooseByKey(event: JSX.TargetedKeyboardEvent<SVGGElement>, name: string): void {
  const names = (calibration.value?.marks ?? []).map((one) => one.mark);
  const way = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1, ' ': 0, Enter: 0 }[event.key];
  if (way === undefined) return;
  event.preventDefault();
  chosenMark.value = names[(names.indexOf(name) + way + names.length) % names.length] ?? null;
  const group = event.currentTarget.parentElement;
  requestAnimationFrame(() => group?.querySelector<SVGGElement>('[aria-checked=true]')?.focus());
}

/** The sheet from above: its marks, those that were touched, and the next one. A click chooses another. */
function Marks(): JSX.Element | null {
  const now = calibration.value;
  if (!now?.marks || !now.paper_m) return null;
  const [width, height] = now.paper_m.map((length) => 1000 * length) as [number, number];
  const touched = new Map(now.touch?.marks.map((one) => [one.mark, one]));
  return (
    <div class="calibrate-marks">
      <svg viewBox={`${-width / 2} ${-height / 2} ${width} ${height}`} role="radiogroup" aria-label={t('cal.touch.marks')}>
        <rect class="calibrate-paper" x={-width / 2} y={-height / 2} width={width} height={height} />
        {now.marks.map(({ mark: name, x_m, y_m }) => (
          <g
            key={name}
            class={`calibrate-mark${touched.has(name) ? ' touched' : ''}${name === mark.value ? ' next' : ''}`}
            transform={`translate(${1000 * x_m} ${-1000 * y_m})`}
            role="radio"
            tabIndex={name === mark.value ? 0 : -1}
            aria-checked={name === mark.value}
            aria-label={touched.has(name) ? t('cal.touch.is_touched', { mark: name }) : name}
            onClick={() => (chosenMark.value = name)}
            onKeyDown={(event) => chooseByKey(event, name)}
          >
            <circle r="11" />
            {name.startsWith('tag') ? <rect class="calibrate-mark-tag" x="-6" y="-6" width="12" height="12" /> : <path d="M-7 0H7M0-7V7" />}
            <text y="21">{name}</text>
          </g>
        ))}
      </svg>
      <ul aria-label={t('cal.touch.touched')}>
        {[...touched.values()].map((one) => (
          <li key={one.mark}>
            <b>{one.mark}</b>
            <span class="muted" title={t('cal.touch.off.how')}>{one.off_m !== undefined ? t('cal.touch.off', { mm: decimals(1000 * one.off_m, 1) }) : ''}</span>
            <Delete what={{ mark: one.mark }} label={t('cal.touch.delete', { mark: one.mark })} />
          </li>
        ))}
        {touched.size === 0 && <li class="muted">{t('cal.touch.none')}</li>}
      </ul>
    </div>
  );
}

/** Where in the picture a view has its tags. */
function Small({ view, width, height }: { view: CalibrationView; width: number; height: number }): JSX.Element {
  return (
    <svg class="calibrate-small" viewBox={`0 0 ${width} ${height}`} aria-hidden="true">
      {view.corners_px.map((corners, i) => (
        <polygon key={i} points={outline(corners)} />
      ))}
    </svg>
  );
}

function Result(): JSX.Element {
  const now = calibration.value;
  const result = now?.result;
  if (!result) {
    return (
      <>
        <p class="calibrate-trouble" role="alert">
          {now?.trouble ? complaintSentence(now.trouble) : t('cal.result.none')}
        </p>
        <button type="button" class="primary big" onClick={() => void goTo('board')}>
          {t('cal.result.more')}
        </button>
      </>
    );
  }
  return (
    <>
      <div class="calibrate-figure">
        <strong>{decimals(1000 * result.table_error_m, 1)} mm</strong>
        <span>{t('cal.result.error')}</span>
      </div>
      <p class="hint">{t('cal.result.honest')}</p>
      <dl class="calibrate-facts">
        <dt>{t('cal.result.reprojection')}</dt>
        <dd>{decimals(result.reprojection_px, 2)} px</dd>
        <dt>{t('cal.touch.error')}</dt>
        <dd>{now.touch?.error_m !== undefined ? `${decimals(1000 * now.touch.error_m, 1)} mm` : t('cal.touch.not_measured')}</dd>
        <dt>{t('cal.result.views')}</dt>
        <dd>{views.value.length}</dd>
        <dt>{t('cal.result.height')}</dt>
        <dd>{decimals(1000 * result.pose.z_m, 0)} mm</dd>
        <dt>{t('cal.result.focal')}</dt>
        <dd>
          {decimals(result.fx_px, 0)}, {decimals(result.fy_px, 0)} px
        </dd>
      </dl>
      {result.ambiguous && <p class="calibrate-trouble">{t('cal.result.ambiguous')}</p>}
      {now?.better && (
        <p class="calibrate-better">
          <Icon name="eye" size={16} /> {t('cal.result.better', { how: complaintSentence(now.better) })}
        </p>
      )}
      <label class="calibrate-stays">
        <input type="checkbox" checked={sheetStays.value} onChange={(event) => (sheetStays.value = event.currentTarget.checked)} />
        <span>{t('cal.result.stays')}</span>
      </label>
      {now?.table_robot && !now.touch && <p class="calibrate-trouble">{t('cal.result.touched_before', { robot: now.table_robot })}</p>}
      <Told />
      <div class="row">
        <button type="button" class="primary big" disabled={busy.value || viewer() || !now?.file} onClick={() => void save()}>
          <Icon name="save" /> {t('cal.save')}
        </button>
        <button type="button" class="big" disabled={busy.value || viewer()} onClick={() => void goTo('board')}>
          {t('cal.result.more')}
        </button>
      </div>
      <p class="hint calibrate-file">{now?.file ? t('cal.save.file', { file: now.file }) : t('cal.save.nowhere')}</p>
    </>
  );
}

function Saved(): JSX.Element {
  const now = saved.value!;
  return (
    <>
      <div class="calibrate-figure">
        <strong>{decimals(1000 * now.table_error_m, 1)} mm</strong>
        <span>{t('cal.result.error')}</span>
      </div>
      <p class="calibrate-told taken" role="status">
        <Icon name="check" size={16} /> {t('cal.saved')}
      </p>
      <p class="hint calibrate-file">{t('cal.saved.file', { file: now.file })}</p>
      <p class="hint">{t(now.sheet_stays ? 'cal.saved.stays' : 'cal.saved.sheet_off')}</p>
      <button type="button" class="primary big" onClick={() => void leave(false)}>
        {t('cal.saved.close')}
      </button>
    </>
  );
}
