import type { JSX } from 'preact';
import { t, tWord } from '../i18n';
import { go, robot, store } from '../app';
import { whatLimits } from '../logic/glance';
import { remedyOf } from '../logic/remedy';
import { duration } from '../logic/units';
import type { CellRobot, RobotStatus } from '../logic/types';

/** Every robot at a glance; the one that is chosen says more. */
export function RobotRail(): JSX.Element {
  return (
    <nav class="rail" aria-label={t('app.robots')} data-tour="robots" inert={store.connection.value !== 'open'}>
      {store.robots.value.map((one) => (
        <RobotCard key={one.name} place={one} status={store.status.value[one.name]} />
      ))}
    </nav>
  );
}

function RobotCard({ place, status }: { place: CellRobot; status: RobotStatus | undefined }): JSX.Element {
  const chosen = robot.value === place.name;
  if (!status) return <div class="card" aria-busy="true" />;
  const lease = store.lease(place.name);
  const limit = whatLimits(status, lease, place.time_scale);
  // Where some machines are real, each says what it is.
  const mixed = store.robots.value.some((one) => one.simulated !== place.simulated);
  const running = status.job && !status.job.over && status.job.phase === 'running';
  return (
    <article class={`card${chosen ? ' chosen' : ''}${status.fault || status.trouble ? ' grave' : ''}`}>
      <button
        type="button"
        class="card-face"
        aria-current={chosen}
        onClick={() => go({ robot: place.name })}
      >
        <span class="card-head">
          <span class={`dot dot-${status.state}`} aria-hidden="true" />
          <span class="card-name">{place.name}</span>
          {place.time_scale !== 1 && <span class="card-scale">{t('app.scale', { scale: place.time_scale })}</span>}
          {mixed && <span class="card-scale">{t(place.simulated ? 'app.simulated' : 'app.real')}</span>}
          <span class="card-state">{t(`state.${status.state}`)}</span>
        </span>
        <span class="card-title">{place.title}</span>
        <span class={`card-quality quality-${status.position}`}>{t(`quality.${status.position}`)}</span>
        {limit.key !== 'none' && (
          <span class={`card-limit${limit.grave ? ' grave' : ''}`}>{tWord('limit', limit.key, limit.values)}</span>
        )}
        {running && place.time_scale !== 1 && (
          <span class="card-real">{t('app.scale.real', { time: duration(status.job!.predicted_s) })}</span>
        )}
        {running && (
          <span class="bar" role="progressbar" aria-valuenow={Math.round(100 * status.job!.progress)} aria-valuemin={0} aria-valuemax={100}>
            <span style={{ width: `${100 * status.job!.progress}%` }} />
          </span>
        )}
      </button>
      {chosen && store.role.value === 'operator' && <CardActions name={place.name} status={status} />}
    </article>
  );
}

function CardActions({ name, status }: { name: string; status: RobotStatus }): JSX.Element {
  const lease = store.lease(name);
  const on = status.state !== 'off';
  const remedy = status.fault ? remedyOf({ code: status.fault.error.code, cause: status.fault.cause }) : null;
  return (
    <div class="card-actions">
      <span class={`lease lease-${lease}`}>{t(`lease.${lease}`)}</span>
      {remedy && (
        <p class="card-remedy">
          {t('remedy.do')}: {t(remedy.todo)}
        </p>
      )}
      <div class="row">
        {lease === 'mine' ? (
          <button type="button" onClick={() => void store.release(name)}>
            {t('lease.release')}
          </button>
        ) : (
          <button
            type="button"
            title={lease === 'other' ? t('lease.take_over.title') : undefined}
            onClick={() => void store.control(name, lease === 'other')}
          >
            {t(lease === 'other' ? 'lease.take_over' : 'lease.take')}
          </button>
        )}
        {status.state === 'moving' && (
          <button type="button" onClick={() => void store.ask('robot.hold', { robot: name })}>
            {t('robot.hold')}
          </button>
        )}
        {(status.state === 'held' || status.job?.phase === 'paused') && (
          <button type="button" class="primary" onClick={() => void store.resume(name)}>
            {t(store.guarded(name) ? 'robot.resume.guarded' : 'robot.resume')}
          </button>
        )}
        {status.state === 'fault' ? (
          <button type="button" class="primary" onClick={() => void store.acknowledge(name)}>
            {t('events.acknowledge')}
          </button>
        ) : (
          <button
            type="button"
            class={on ? '' : 'primary'}
            disabled={lease === 'other' || status.state === 'enabling'}
            onClick={() => void (on ? store.disable(name) : store.enable(name))}
          >
            {t(on ? 'robot.disable' : 'robot.enable')}
          </button>
        )}
      </div>
    </div>
  );
}
