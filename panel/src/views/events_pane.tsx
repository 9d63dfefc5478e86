import type { JSX } from 'preact';
import { useSignal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { errorSentence, language, t, tWord } from '../i18n';
import { store } from '../app';
import { newestFirst } from '../logic/paging';
import { isGrave } from '../logic/store';
import type { EventJson, LimitedJson, RobotStatus } from '../logic/types';
import { duration } from '../logic/units';
import { Icon, Segments } from './parts';
import { Older } from './older';
import { RemedyText } from './remedy';

const kPage = 200;

const heldBack = (limited?: LimitedJson): string =>
  limited ? tWord('move.limited', limited.by, { joint: limited.joint ?? '' }) : '';

/** What happened, what it means, what it wants. Nothing goes away by itself. */
export function EventsPane(): JSX.Element {
  const filter = useSignal<'all' | 'grave'>('all');
  const events = store.events.value;
  const last = events.at(-1)?.number ?? 0;
  // Looked at as long as the list is open.
  useEffect(() => {
    store.seen.value = last;
  }, [last]);
  const count = useSignal(kPage);
  const wanted = events.filter((one) => filter.value === 'all' || isGrave(one));
  const { shown, more } = newestFirst(wanted, count.value);
  return (
    <div class="pane-body" data-tour="events">
      {store.faults.value.length > 0 && (
        <section aria-label={t('events.faults')}>
          <h3>{t('events.faults')}</h3>
          {store.faults.value.map((one) => (
            <FaultCard key={one.robot} status={one} />
          ))}
        </section>
      )}
      <Segments
        hideLabel
        label={t('events.title')}
        value={filter.value}
        options={(['all', 'grave'] as const).map((value) => ({ value, text: t(`events.filter.${value}`) }))}
        onChange={(value) => (filter.value = value)}
      />
      {shown.length === 0 ? (
        <p class="empty">{t('events.none')}</p>
      ) : (
        <ol class="events">
          {shown.map((one) => (
            <EventRow key={one.number} event={one} />
          ))}
        </ol>
      )}
      <Older more={more} onClick={() => (count.value += kPage)} />
      {more === 0 && store.eventsGone.value > 0 && <p class="hint">{t('list.gone', { count: store.eventsGone.value })}</p>}
    </div>
  );
}

function FaultCard({ status }: { status: RobotStatus }): JSX.Element {
  const fault = status.fault!;
  return (
    <article class="callout grave" role="alert">
      <h4>
        <Icon name="fault" /> {status.robot}
      </h4>
      <p>{errorSentence(fault.error)}</p>
      <p class="muted">{tWord('cause', fault.cause)}</p>
      <RemedyText code={fault.error.code} cause={fault.cause} />
      {fault.later?.map((one, i) => (
        <div key={i}>
          <p class="muted">{t('events.later', { text: errorSentence(one.error) })}</p>
          {one.error.code !== fault.error.code && <RemedyText code={one.error.code} cause={one.cause} />}
        </div>
      ))}
      <button
        type="button"
        class="primary"
        title={t('events.acknowledge.help')}
        onClick={() => void store.acknowledge(status.robot)}
      >
        {t('events.acknowledge')}
      </button>
    </article>
  );
}

function EventRow({ event }: { event: EventJson }): JSX.Element {
  const at = new Date(event.at_ms);
  const time = at.toLocaleTimeString(language.value, { hour12: false });
  const day = at.toDateString() === new Date().toDateString() ? '' : `${at.toLocaleDateString(language.value)} `;
  return (
    <li class={`event kind-${event.kind}${isGrave(event) ? ' grave' : ''}`}>
      <time dateTime={at.toISOString()}>{day + time}</time>
      <strong>{event.robot}</strong>
      <span>{eventText(event)}</span>
      {kRemedied.includes(event.kind) && <RemedyText code={event.error?.code} cause={event.cause} />}
    </li>
  );
}

/** Of whatever has brought a robot to rest. */
const kRemedied: readonly EventJson['kind'][] = ['fault', 'stop', 'notice', 'job'];

export function eventText(event: EventJson): string {
  switch (event.kind) {
    case 'state':
      return t('events.state', { state: tWord('state', event.state ?? '') });
    case 'lease':
      return t(event.client ? 'events.lease.taken' : 'events.lease.free');
    case 'stop':
      return t('events.stop', { cause: tWord('cause', event.cause ?? '') });
    case 'fault':
    case 'notice':
      return event.error ? errorSentence(event.error) : tWord('cause', event.cause ?? '');
    case 'job':
      return tWord('events.job', event.phase ?? '', {
        title: event.title ?? '',
        time: duration(event.predicted_s ?? 0),
        text: event.error ? errorSentence(event.error) : heldBack(event.limited),
      });
    case 'record':
      return event.trouble ?? t('events.record', { path: event.path ?? '' });
    case 'procedure':
      return tWord('events.procedure', event.phase ?? '', {
        title: tWord('procedure', event.procedure ?? ''),
        text: event.trouble ?? '',
      });
    case 'demonstration':
      return t(event.runs ? 'demonstration.begins' : 'demonstration.over');
    case 'begun':
      return event.trouble ? t('events.not_kept', { text: event.trouble }) : t('events.begun', { version: event.version ?? '' });
    case 'declared':
      return event.reason ? t('events.moved', { reason: event.reason }) : t('events.declared');
    case 'declaration_refused':
      return t('events.declaration_refused', { text: event.trouble ?? '' });
  }
}
