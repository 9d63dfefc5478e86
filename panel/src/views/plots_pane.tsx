import type { JSX } from 'preact';
import { useSignal } from '@preact/signals';
import { useRef } from 'preact/hooks';
import { language, t, tWord } from '../i18n';
import { store } from '../app';
import { csvOf, kQuantities, linesOf } from '../logic/series';
import { firstOf, newestFirst } from '../logic/paging';
import { lengthOf, type RunRecord } from '../logic/record';
import { decimals, duration } from '../logic/units';
import { handOver } from '../hand_over';
import {
  candidates,
  choosable,
  choose,
  loadRecord,
  mode,
  picks,
  playhead,
  playing,
  quantities,
  record,
  recordName,
  recordTrouble,
  setQuantity,
  standsFor,
  type Choosable,
} from '../plots_state';
import { Swatch } from './chart';
import { records } from '../records_state';
import { Older } from './older';
import { Icon, Segments } from './parts';
import { Recorder, RecordsList } from './records_list';

const kEventsPage = 300;
const kToldPage = 50;

/** What is plotted: as it comes, or of a record; which quantities, robots and joints. */
export function PlotsPane(): JSX.Element {
  return (
    <div class="pane-body plots" data-tour="plots">
      <Segments
        hideLabel
        label={t('plots.source')}
        value={mode.value}
        options={(['live', 'record'] as const).map((value) => ({ value, text: t(`plots.${value}`) }))}
        onChange={(value) => {
          playing.value = false;
          mode.value = value;
        }}
      />
      <Recorder />
      {mode.value === 'record' && <RecordPart />}
      {(mode.value === 'live' || record.value) && (
        <>
          <fieldset class="checks">
            <legend>{t('plots.what')}</legend>
            {kQuantities
              .filter((one) => mode.value === 'live' || one !== 'latency')
              .map((one) => (
                <label key={one} class="check">
                  <input
                    type="checkbox"
                    checked={quantities.value.includes(one)}
                    onChange={(event) => setQuantity(one, event.currentTarget.checked)}
                  />
                  {t(`plots.${one}`)}
                  <small>{t(`plots.${one}.help`)}</small>
                </label>
              ))}
          </fieldset>
          {choosable.value.map((one) => (
            <RobotChecks key={one.name} of={one} />
          ))}
        </>
      )}
      {mode.value === 'live' && <p class="hint">{t('plots.zoom.help')}</p>}
    </div>
  );
}

function RobotChecks({ of }: { of: Choosable }): JSX.Element {
  const on = of.joints.filter((joint) => picks.value.some((one) => one.robot === of.name && one.joint === joint.joint));
  const all = on.length === of.joints.length;
  const some = useRef<HTMLInputElement>(null);
  // Its speeds are in its own time, the picture's axis is in ours.
  const scale = mode.value === 'live' ? store.timeScale(of.name) : 1;
  if (some.current) some.current.indeterminate = on.length > 0 && !all;
  return (
    <fieldset class="checks checks-robot">
      <legend>
        <label class="check">
          <input
            ref={some}
            type="checkbox"
            checked={all}
            onChange={() => choose(of.name, of.joints.map((joint) => joint.name), !all)}
          />
          {of.name}
          {scale !== 1 && <span class="card-scale">{t('app.scale', { scale })}</span>}
        </label>
      </legend>
      <div class="check-joints">
        {of.joints.map((joint) => (
          <label key={joint.name} class="check">
            <input
              type="checkbox"
              checked={on.includes(joint)}
              onChange={(event) => choose(of.name, [joint.name], event.currentTarget.checked)}
            />
            <Swatch hue={joint.hue} /> {joint.name}
          </label>
        ))}
      </div>
    </fieldset>
  );
}

function RecordPart(): JSX.Element {
  const input = useRef<HTMLInputElement>(null);
  const one = record.value;
  const take = (files: FileList | null | undefined) => {
    if (files?.[0]) void loadRecord(files[0]);
  };
  return (
    <section class="records">
      <div
        class="record-drop"
        onDragOver={(event) => event.preventDefault()}
        onDrop={(event) => {
          event.preventDefault();
          take(event.dataTransfer?.files);
        }}
      >
        <input
          ref={input}
          type="file"
          accept=".mcap"
          class="sr-only"
          tabIndex={-1}
          aria-label={t('plots.record.open')}
          onChange={(event) => {
            take(event.currentTarget.files);
            event.currentTarget.value = '';
          }}
        />
        <button type="button" class={one ? '' : 'primary'} onClick={() => input.current?.click()}>
          <Icon name="folder" size={16} /> {t('plots.record.open')}
        </button>
        <p class="hint">{t('plots.record.drop')}</p>
      </div>
      {recordTrouble.value && (
        <p class="setup-refused" role="alert">
          {recordTrouble.value}
        </p>
      )}
      {one && <RecordFacts of={one} />}
      <RecordsList />
      <Told />
    </section>
  );
}

function RecordFacts({ of }: { of: RunRecord }): JSX.Element {
  const here = candidates(of, store.robots.value, store.models.value);
  const count = useSignal(kEventsPage);
  const events = firstOf(of.events, count.value);
  return (
    <>
      <dl class="facts">
        <div>
          <dt>{t('plots.record.file')}</dt>
          <dd>{recordName.value}</dd>
        </div>
        <div>
          <dt>{t('plots.record.robot')}</dt>
          <dd>
            {of.robot}
            {of.model && of.model !== of.robot && ` (${of.model})`}
          </dd>
        </div>
        {of.program && (
          <div>
            <dt>{t('plots.record.program')}</dt>
            <dd>{of.program}</dd>
          </div>
        )}
        <div>
          <dt>{t('plots.record.began')}</dt>
          <dd>{new Date(of.startedMs).toLocaleString(language.value)}</dd>
        </div>
        <div>
          <dt>{t('plots.record.length')}</dt>
          <dd>{t('plots.record.samples', { time: duration(lengthOf(of)), count: of.frames.length })}</dd>
        </div>
      </dl>
      {!of.whole && <p class="question-trouble">{t('plots.record.cut')}</p>}
      {of.lost > 0 && <p class="question-trouble">{t('plots.record.lost', { count: of.lost })}</p>}
      {here.length === 0 ? (
        <p class="hint">{t('plots.record.nobody')}</p>
      ) : (
        <label class="record-on">
          <span class="field-label">{t('plots.record.on')}</span>
          <select value={standsFor.value ?? ''} onChange={(event) => (standsFor.value = event.currentTarget.value)}>
            {here.map((name) => (
              <option key={name}>{name}</option>
            ))}
          </select>
        </label>
      )}
      <button type="button" onClick={() => saveWhole(of)}>
        <Icon name="save" size={16} /> {t('plots.record.csv')}
      </button>
      {of.events.length > 0 && (
        <details class="record-events">
          <summary>{t('plots.record.events', { count: of.events.length })}</summary>
          <ol>
            {events.shown.map((event, i) => (
              <li key={i}>
                <button type="button" class={`quiet${event.grave ? ' grave' : ''}`} onClick={() => (playhead.value = event.t)}>
                  <span>{decimals(event.t, 2)} s</span>
                  <strong>{tWord('plots.event', event.kind)}</strong>
                  <span>{event.text}</span>
                </button>
              </li>
            ))}
          </ol>
          <Older forward more={events.more} onClick={() => (count.value += kEventsPage)} />
        </details>
      )}
    </>
  );
}

/** All joints and all that a record can tell of them. */
function saveWhole(of: RunRecord): void {
  const all = choosable.value.flatMap((one) => one.joints);
  const charts = (['position', 'velocity', 'acceleration', 'error'] as const).map((quantity) => ({
    quantity,
    lines: linesOf(of.frames, all, quantity, { trip: '', late: '' }),
  }));
  handOver(`${recordName.value.replace(/\.mcap$/i, '')}.csv`, csvOf(of.frames.map((one) => one.t), charts), 'text/csv;charset=utf-8');
}

/** Records that lie somewhere else beside the controller: those of --record-folder. */
function Told(): JSX.Element | null {
  const folder = records.value?.folder;
  const told = store.events.value.filter((one) => one.kind === 'record' && one.path && !(folder && one.path.startsWith(`${folder}/`)));
  const count = useSignal(kToldPage);
  const { shown, more } = newestFirst(told, count.value);
  if (told.length === 0) return null;
  return (
    <section aria-label={t('plots.told.else')}>
      <h3>{t('plots.told.else')}</h3>
      <ul class="told">
        {shown.map((event) => (
          <li key={event.number}>
            <time>{new Date(event.at_ms).toLocaleTimeString(language.value, { hour12: false })}</time>
            <strong>{event.robot}</strong>
            {event.cause && <span class="tag">{tWord('cause', event.cause)}</span>}
            <code>{event.path}</code>
            {event.trouble && <span class="question-trouble">{event.trouble}</span>}
          </li>
        ))}
      </ul>
      <Older more={more} onClick={() => (count.value += kToldPage)} />
    </section>
  );
}
