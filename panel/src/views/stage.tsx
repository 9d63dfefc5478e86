import type { JSX } from 'preact';
import { useSignalEffect } from '@preact/signals';
import { useEffect, useRef, useState } from 'preact/hooks';
import { t } from '../i18n';
import { aim, ghost, gizmoMode, go, model, robot, route, standing, status, store, target, theme } from '../app';
import { newestFirst } from '../logic/paging';
import { canTurn, withTool } from '../logic/target';
import { CellScene, type Preset } from '../scene/scene';
import { baskets, camera, lenses, looksOn, picture, shot } from '../camera_state';
import { hoveredJoint, layers, look, meantJoint } from '../scene_state';
import { replayGhost } from '../plots_state';
import { dragged, reach } from '../table_state';
import { ghost as programGhost } from '../teach';
import { Older } from './older';
import { NoteCard } from './note';
import { pressedNote } from './pressed_note';
import { WireDock } from './wire_dock';
import { Icon, Toggle } from './parts';
import { PlotDock } from './plot_dock';
import { PlotsDock } from './plots_dock';

const kPresets: Preset[] = ['iso', 'front', 'side', 'top', 'oblique'];

/** The cell in 3D with what belongs to it. */
export function Stage(): JSX.Element {
  const host = useRef<HTMLDivElement>(null);
  const labels = useRef<HTMLDivElement>(null);
  const scene = useRef<CellScene | null>(null);
  const [fails, setFails] = useState(false);

  useEffect(() => {
    try {
      scene.current = new CellScene({
        host: host.current!,
        labels: labels.current!,
        plain: { full: false, plain: true }[localStorage.getItem('sinew.drawing') ?? ''],
        onPick: (name) => go({ robot: name }),
        onGizmo: (name, pose) => {
          const now = target.peek() ?? standing();
          if (now && now.robot === name) aim(withTool(now, pose));
        },
      });
      Object.assign(window, { sinewScene: scene.current });
    } catch {
      setFails(true);
    }
    return () => scene.current?.dispose();
  }, []);

  useSignalEffect(() => {
    const cell = store.cell.value;
    const models = store.models.value;
    if (cell && scene.current) {
      scene.current.setCell(cell, models, theme.peek());
      scene.current.select(robot.peek());
    }
  });
  useSignalEffect(() => {
    for (const one of Object.values(store.status.value)) scene.current?.setStatus(one.robot, one);
  });
  useSignalEffect(() => scene.current?.paint(theme.value));
  const shown = useRef<string | null>(null);
  useSignalEffect(() => {
    const name = robot.value;
    scene.current?.select(name);
    // The first one is nobody's choice: the page opens with the whole cell.
    if (name && shown.current && name !== shown.current) scene.current?.focus();
    shown.current = name;
  });
  // Programs are about one robot, and leave less room for all of them.
  const { view } = route.value;
  useEffect(() => {
    if (view === 'programs') requestAnimationFrame(() => scene.current?.focus());
  }, [view]);
  useSignalEffect(() => scene.current?.setLayers(layers.value));
  useSignalEffect(() => {
    void store.cell.value;
    scene.current?.showCubes(shot.value?.cubes ?? []);
  });
  useSignalEffect(() => scene.current?.showFrustums(lenses.value));
  useSignalEffect(() => {
    const moved = dragged.value;
    scene.current?.showBaskets(baskets.value.map((one) => (one.name === moved?.name ? moved : one)));
  });
  useSignalEffect(() => {
    void store.cell.value;
    scene.current?.showRegion(reach.value);
  });
  useSignalEffect(() => {
    const { preset, all } = look.value;
    if (all) scene.current?.showAll(preset);
    else scene.current?.show(preset);
  });
  useSignalEffect(() => {
    // A robot that is not here yet cannot be shown.
    void store.cell.value;
    const { view } = route.value;
    const now =
      view === 'move' ? ghost.value : view === 'programs' ? programGhost.value : replayGhost.value;
    if (now) scene.current?.showGhost(now);
    else scene.current?.hideGhost();
  });
  useSignalEffect(() => {
    // A new cell is drawn anew.
    void store.cell.value;
    const meant = route.value.view === 'setup' ? meantJoint.value : null;
    scene.current?.markJoint(meant?.robot ?? null, meant?.joint ?? 0);
  });
  useSignalEffect(() => {
    const joint = hoveredJoint.value;
    const now = target.value;
    // Follows the robot while it is shown.
    if (joint !== null) void status.value;
    scene.current?.showLimits(joint, joint !== null && now ? now.joints[joint] : undefined);
  });
  useSignalEffect(() => {
    const one = model.value;
    const now = route.value.view === 'move' ? (target.value ?? standing()) : null;
    const turn = gizmoMode.value === 'rotate' && one !== null && canTurn(one);
    const upright = one?.task === 'yaw';
    scene.current?.showGizmo(
      now && one
        ? { robot: now.robot, pose: now.tool, mode: turn ? 'rotate' : 'translate', space: turn && !upright ? 'local' : 'world', upright }
        : null,
    );
  });

  return (
    <section class="stage" aria-label={t('app.view')}>
      <div class="canvas" ref={host}>
        {fails && <p class="empty">{t('scene.none')}</p>}
        <div class="labels" ref={labels} aria-hidden="true" />
        <ViewBar />
        <LookingOn />
        <Notes />
      </div>
      {route.value.view === 'move' && <PlotDock />}
      {route.value.view === 'plots' && <PlotsDock />}
      {route.value.view === 'device' && <WireDock />}
    </section>
  );
}

/** What a running program saw last. */
function LookingOn(): JSX.Element | null {
  if (!looksOn.value || !picture.value) return null;
  return (
    <button type="button" class="looking-on" title={t('scene.camera.open')} onClick={() => go({ view: 'camera' })}>
      <img src={picture.value} alt={t('camera.picture')} />
      <span>{t('scene.camera', { name: camera.value!.name, count: shot.value?.cubes?.length ?? 0 })}</span>
    </button>
  );
}

function ViewBar(): JSX.Element {
  const wish = (preset: Preset) => (look.value = { preset, all: look.value.all });
  return (
    <div class="view-bar" role="toolbar" aria-label={t('scene.preset')}>
      <div class="bar-group">
        {kPresets.map((preset) => (
          <button type="button" key={preset} class="chip" onClick={() => wish(preset)}>
            {t(`scene.${preset}`)}
          </button>
        ))}
        <button
          type="button"
          class="chip"
          title={t('scene.fit')}
          onClick={() => (look.value = { preset: look.value.preset, all: false })}
        >
          <Icon name="fit" size={15} /> {robot.value ?? t('scene.fit')}
        </button>
        <button
          type="button"
          class="chip"
          onClick={() => (look.value = { preset: look.value.preset, all: true })}
        >
          {t('scene.all')}
        </button>
      </div>
      <div class="bar-group" role="group" aria-label={t('scene.layers')}>
        {(['trail', 'reach', 'bodies', 'objects'] as const)
          .filter((one) => one !== 'objects' || (store.cell.value?.objects.length ?? 0) > 0)
          .map((one) => (
            <Toggle
              key={one}
              pressed={layers.value[one]}
              onChange={(on) => (layers.value = { ...layers.value, [one]: on })}
            >
              {t(`scene.${one}`)}
            </Toggle>
          ))}
      </div>
    </div>
  );
}

const kNotesShown = 3;
const kNotesPage = 20;

/** Refusals and the like, until somebody has read them: the newest, and the others where they are asked for. */
function Notes(): JSX.Element {
  const [count, setCount] = useState(kNotesShown);
  const beside = pressedNote();
  const all = store.notes.value.filter((one) => one !== beside);
  const { shown, more } = newestFirst(all, count);
  useEffect(() => {
    if (all.length <= kNotesShown) setCount(kNotesShown);
  }, [all.length <= kNotesShown]);
  return (
    <div class="notes">
      {all.length > kNotesShown && (
        <div class="notes-more">
          <Older more={more} onClick={() => setCount((before) => before + kNotesPage)} />
          {count > kNotesShown && (
            <button type="button" class="quiet" onClick={() => setCount(kNotesShown)}>
              {t('list.newest')}
            </button>
          )}
          <button type="button" class="quiet" onClick={() => store.dismissAll()}>
            {t('note.dismiss_all')}
          </button>
          {store.notesGone.value > 0 && <p class="hint">{t('list.gone', { count: store.notesGone.value })}</p>}
        </div>
      )}
      <div class="notes-list" aria-live="polite">
        {shown.reverse().map((note) => (
          <NoteCard note={note} key={note.id} />
        ))}
      </div>
    </div>
  );
}
