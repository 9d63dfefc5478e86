import { render, type JSX } from 'preact';
import './styles/font.css';
import './styles/panel.css';
import './styles/programs.css';
import './styles/help.css';
import './styles/plots.css';
import './styles/setup.css';
import './styles/device.css';
import './styles/camera.css';
import './styles/camera_table.css';
import './styles/calibration.css';
import { announced, go, murmured, robot, route, start, store, unheard } from './app';
import { t } from './i18n';
import { kViewIds, type ViewId } from './view_ids';
import { age } from './logic/units';
import { kViews } from './views';
import { Icon } from './views/parts';
import { PressedNote } from './views/pressed_note';
import { RobotRail } from './views/robot_rail';
import { Stage } from './views/stage';
import { TopBar } from './views/top_bar';
import { Tour } from './views/tour';

function Page(): JSX.Element {
  const cut = store.connection.value !== 'open';
  return (
    <div class="page" data-old={store.age.value !== null}>
      <a class="skip" href="#controls" onClick={skip}>
        {t('app.skip')}
      </a>
      <TopBar />
      <RobotRail />
      <main class="work" data-view={route.value.view} inert={cut}>
        <Stage />
        <Pane />
      </main>
      <Tour />
      <PressedNote />
      {cut && <Veil />}
      <div class="sr-only" aria-live="polite">
        {murmured.value}
      </div>
      <div class="sr-only" aria-live="assertive">
        <span key={announced.value.count}>{announced.value.text}</span>
      </div>
    </div>
  );
}

function skip(event: Event): void {
  event.preventDefault();
  document.querySelector<HTMLElement>('#controls')?.focus();
}

function Pane(): JSX.Element {
  const view = route.value.view as ViewId;
  const Shown = kViews[view].show;
  return (
    <aside class="pane" id="controls" tabIndex={-1} aria-label={t('app.controls')}>
      <nav class="tabs" aria-label={t('app.controls')}>
        {kViewIds.map((id) => (
          <a
            key={id}
            href={`#/${robot.value ? `robots/${robot.value}/` : ''}${id}`}
            aria-current={id === view ? 'page' : undefined}
            onClick={(event) => {
              event.preventDefault();
              go({ view: id });
            }}
          >
            <Icon name={kViews[id].icon} /> {t(`view.${id}`)}
            {id === 'events' && store.unseen.value + store.faults.value.length > 0 && (
              <span class="badge">{store.unseen.value + store.faults.value.length}</span>
            )}
          </a>
        ))}
      </nav>
      <div class="pane-scroll" key={view} role="region" aria-label={t(`view.${view}`)} tabIndex={0}>
        {store.role.value === 'viewer' && <p class="callout watching">{t('role.viewer.help')}</p>}
        <Shown />
      </div>
    </aside>
  );
}

/** Nothing on the page is true while there is no connection; Stop stays where it is. */
function Veil(): JSX.Element {
  const first = store.cell.value === null;
  const away = store.turnedAway.value;
  return (
    <div class={`veil${first ? ' first' : ''}`}>
      <span class="spinner" aria-hidden="true" />
      <p role="status">{t(away === null ? `connection.${store.connection.value}` : 'connection.turned_away')}</p>
      {!first && <p class="muted">{t('connection.old', { age: age(store.age.value ?? 0) })}</p>}
      {unheard.value && (
        <p class="veil-grave" role="alert">
          {t('stop.failed')}. {t('stop.power')}
        </p>
      )}
      {(first || away !== null) && <p class="muted">{away ?? t('connection.token')}</p>}
    </div>
  );
}

render(<Page />, document.getElementById('app')!);
start();
