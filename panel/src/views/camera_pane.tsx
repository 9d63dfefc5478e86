import type { JSX } from 'preact';
import { complaintSentence, errorSentence, t, tWord } from '../i18n';
import { atWork, canMove, robot, status, store } from '../app';
import { calibration, openWizard, unsaved } from '../calibration_state';
import { basket, calibrating, camera, cameras, chosenCamera, chosenCube, disturb, pick, picture, shot, sort } from '../camera_state';
import { countColors, onTable, paintOf, whyKey } from '../logic/camera';
import { cameraTroubles, type CameraShot, type CameraTrouble, type SeenCubeJson } from '../logic/types';
import { decimals } from '../logic/units';
import { resume, stopJob } from '../teach';
import { TableControls, TableOverlay, whyNot } from './camera_table';
import { CalibrationWizard } from './calibration_wizard';
import { Icon, Segments } from './parts';

/** What a camera sees: its picture with the cubes in it, and what can be done with them. */
export function CameraPane(): JSX.Element {
  if (!camera.value) {
    return (
      <div class="pane-body">
        <p class="empty">{t('camera.none')}</p>
        <p class="hint">{t('camera.none.how')}</p>
      </div>
    );
  }
  const now = shot.value;
  return (
    <div class="pane-body camera" data-tour="camera">
      {cameras.value.length > 1 && (
        <Segments
          label={t('view.camera')}
          value={camera.value.name}
          options={cameras.value.map((one) => ({ value: one.name, text: one.name }))}
          onChange={(name) => (chosenCamera.value = name)}
        />
      )}
      {calibrating.value ? <CalibrationWizard /> : <Seen now={now} />}
    </div>
  );
}

/** The picture, and what can be done with the cubes in it. */
function Seen({ now }: { now: CameraShot | null }): JSX.Element {
  const lens = camera.value!.lens;
  const refused = camera.value!.calibration?.refused;
  const under = calibration.value?.under_way;
  return (
    <>
      {now?.fault && (
        <div class="callout camera-fault" role="alert">
          <h4>
            <Icon name="fault" size={17} /> {errorSentence(now.fault)}
          </h4>
          <p>{t('camera.fault.then')}</p>
        </div>
      )}
      <Paused />
      <Picture now={now} />
      {now && !now.fault && <Cubes now={now} />}
      {now && !now.fault && <TableControls now={now} />}
      {now?.trouble && <Trouble now={now.trouble} />}
      <div class="camera-calibration">
        <p class="hint">
          {lens ? t('camera.accuracy', { mm: decimals(1000 * lens.accuracy_m, 1) }) : t('camera.uncalibrated')}
          {refused && ` ${t('cal.refused', { why: complaintSentence(refused) })}`}
          {under && ` ${t('cal.under_way', { count: unsaved.value })}`}
        </p>
        {camera.value!.on_arm ? (
          <p class="hint">{t('camera.on_arm')}</p>
        ) : (
          <button type="button" class={lens && !under ? '' : 'primary'} disabled={store.role.value === 'viewer'} onClick={openWizard}>
            <Icon name="fit" /> {t(under ? 'cal.continue' : lens ? 'cal.calibrate.again' : 'cal.calibrate')}
          </button>
        )}
      </div>
    </>
  );
}

/** Why the program rests, where it rests, and the way on. */
function Paused(): JSX.Element | null {
  const now = status.value?.job;
  if (now?.phase !== 'paused') return null;
  return (
    <div class="callout camera-paused" role="status">
      <h4>
        <Icon name="pause" size={17} /> {t('limit.paused', { title: now.title })}
      </h4>
      {now.paused_by && <p>{errorSentence(now.paused_by)}</p>}
      <button type="button" class="primary" onClick={resume}>
        <Icon name="play" /> {t(store.guarded(robot.value ?? '') ? 'robot.resume.guarded' : 'robot.resume')}
      </button>
    </div>
  );
}

/** What can happen to a simulated camera, to try it. */
function Trouble({ now }: { now: CameraTrouble }): JSX.Element {
  return (
    <div class="camera-trouble">
      <Segments
        label={t('camera.trouble')}
        value={now}
        options={cameraTroubles.map((one) => ({ value: one, text: tWord('camera.trouble', one) }))}
        onChange={(one) => void disturb(one)}
      />
    </div>
  );
}

const points = (corners: readonly (readonly number[])[]): string => corners.map((p) => p.join(',')).join(' ');
const middle = (corners: readonly (readonly number[])[], axis: 0 | 1): number =>
  corners.reduce((sum, p) => sum + p[axis]!, 0) / corners.length;

function Picture({ now }: { now: CameraShot | null }): JSX.Element {
  if (!now?.width_px || !picture.value) return <p class="camera-waits">{t('camera.waits')}</p>;
  const { width_px: width, height_px: height = 1 } = now;
  const stroke = Math.max(1.5, width / 320);
  const names = namesOf(now.cubes ?? []);
  return (
    <div class={`camera-picture${now.fault ? ' stale' : ''}`} style={{ aspectRatio: `${width} / ${height}` }}>
      <img src={picture.value} alt={t('camera.picture')} />
      <svg viewBox={`0 0 ${width} ${height}`} role="group" aria-label={t('camera.cubes')}>
        {now.refused?.map((one, i) => (
          <polygon key={`r${i}`} class="camera-refused" points={points(one.outline_px)} stroke-width={stroke}>
            <title>{tWord('camera.why', whyKey(one.why))}</title>
          </polygon>
        ))}
        <TableOverlay stroke={stroke} />
        {now.cubes?.map((cube, i) => <Outline key={names[i]} cube={cube} index={i} stroke={stroke} />)}
      </svg>
    </div>
  );
}

/** Of each its color and the how manieth of these it is from the left: the same in the next picture, in whatever
 *  order cubes are found there, so that what is clicked stays what it is. */
function namesOf(cubes: readonly SeenCubeJson[]): string[] {
  return cubes.map(({ color, top_px }, i) => {
    const left = cubes.filter((other, k) => other.color === color && (middle(other.top_px, 0) < middle(top_px, 0) || (middle(other.top_px, 0) === middle(top_px, 0) && k < i)));
    return `${color} ${left.length}`;
  });
}

function cubeName(cube: SeenCubeJson): string {
  const color = tWord('color', cube.color);
  if (cube.x_m === undefined) return color;
  return t('camera.cube', { color, x: decimals(1000 * cube.x_m, 0), y: decimals(1000 * cube.y_m!, 0) });
}

function Outline({ cube, index, stroke }: { cube: SeenCubeJson; index: number; stroke: number }): JSX.Element {
  const chosen = chosenCube.value === index;
  const why = whyNot(cube);
  const choose = () => (chosenCube.value = chosen ? null : index);
  return (
    <g
      role="button"
      tabIndex={0}
      aria-pressed={chosen}
      aria-label={cubeName(cube)}
      class={`camera-cube${chosen ? ' chosen' : ''}${why ? ' cannot' : ''}${cube.in_basket ? ' done' : ''}`}
      onClick={choose}
      onKeyDown={(event) => {
        if (event.key !== 'Enter') return;
        event.preventDefault();
        choose();
      }}
    >
      {why && <title>{why}</title>}
      <polygon class="camera-edge" points={points(cube.top_px)} stroke-width={2.4 * stroke} />
      <polygon points={points(cube.top_px)} stroke={paintOf(cube.color)} stroke-width={1.4 * stroke} />
      <circle cx={middle(cube.top_px, 0)} cy={middle(cube.top_px, 1)} r={1.6 * stroke} />
    </g>
  );
}

function Cubes({ now }: { now: CameraShot }): JSX.Element {
  const cubes = now.cubes ?? [];
  const ready = canMove.value && !atWork.value;
  const chosen = chosenCube.value === null ? undefined : cubes[chosenCube.value];
  const here = onTable(cubes).length > 0;
  const takes = ready && chosen?.x_m !== undefined && chosen.in_basket === undefined;
  return (
    <>
      {chosen ? (
        <section class="camera-chosen" aria-label={cubeName(chosen)}>
          <h4>
            <Swatch color={chosen.color} /> {cubeName(chosen)}
          </h4>
          <p class="muted">
            {t('camera.confidence', { percent: Math.round(100 * chosen.confidence) })}
            {chosen.in_basket && ` · ${t('camera.in_basket')}`}
          </p>
          {whyNot(chosen) && <p class="camera-why">{whyNot(chosen)}</p>}
          <div class="row">
            <button type="button" class="primary" disabled={!takes} onClick={() => pick(chosen, false)}>
              <Icon name="grab" /> {t('camera.pick')}
            </button>
            {basket.value && (
              <button type="button" disabled={!takes} onClick={() => pick(chosen, true)}>
                <Icon name="later" /> {t('camera.into', { basket: basket.value.name })}
              </button>
            )}
          </div>
        </section>
      ) : (
        <p class="hint">{t(cubes.length > 0 ? 'camera.click' : 'camera.no_cubes')}</p>
      )}
      {basket.value && (
        <div class="row">
          <button type="button" class="primary big" data-tour="sort" disabled={!ready || !here} onClick={() => sort(null)}>
            <Icon name="play" /> {t('camera.sort', { basket: basket.value.name })}
          </button>
          <button type="button" class="big" disabled={!atWork.value} onClick={stopJob}>
            <Icon name="stop" /> {t('prog.stop')}
          </button>
        </div>
      )}
      {!status.value?.state || status.value.state !== 'off' ? null : (
        <p class="hint">{t('robot.ready_first', { robot: robot.value ?? '' })}</p>
      )}
      <Counts cubes={cubes} ready={ready} />
    </>
  );
}

const Swatch = ({ color }: { color: string }): JSX.Element => (
  <span class="camera-swatch" style={{ background: paintOf(color) }} aria-hidden="true" />
);

function Counts({ cubes, ready }: { cubes: SeenCubeJson[]; ready: boolean }): JSX.Element | null {
  const counts = countColors(cubes);
  if (counts.length === 0) return null;
  return (
    <table class="camera-counts">
      <thead>
        <tr>
          <th scope="col">{t('camera.color')}</th>
          <th scope="col">{t('camera.on_table')}</th>
          <th scope="col">{t('camera.in_basket')}</th>
          <th>
            <span class="sr-only">{t('camera.sort_color')}</span>
          </th>
        </tr>
      </thead>
      <tbody>
        {counts.map((one) => (
          <tr key={one.color}>
            <th scope="row">
              <Swatch color={one.color} /> {tWord('color', one.color)}
            </th>
            <td>{one.table}</td>
            <td>{one.basket}</td>
            <td>
              {basket.value && (
                <button type="button" class="quiet" disabled={!ready || one.table === 0} onClick={() => sort(one.color)}>
                  {t('camera.sort_color')}
                </button>
              )}
            </td>
          </tr>
        ))}
      </tbody>
    </table>
  );
}
