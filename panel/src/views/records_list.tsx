import type { JSX } from 'preact';
import { useState } from 'preact/hooks';
import { language, t, tWord } from '../i18n';
import { store } from '../app';
import { sizeText, type KeptRecord } from '../logic/records';
import { duration } from '../logic/units';
import {
  download,
  fetching,
  giveUp,
  play,
  recorded,
  records,
  recordsTrouble,
  removeRecord,
  startRecording,
  stopRecording,
  wanted,
  wantedNow,
} from '../records_state';
import { IconButton } from './points_list';

const kShown = 12;

/** Records what robots do from now on; the file lies with the controller. */
export function Recorder(): JSX.Element {
  const [title, setTitle] = useState('');
  const now = recorded.value;
  const robots = store.robots.value;
  return (
    <section class="recorder" aria-label={t('rec.title')}>
      {now.length > 0 ? (
        <div class="recording" role="status">
          <span class="recording-mark" aria-hidden="true" />
          <ul>
            {now.map((one) => (
              <li key={one.robot}>
                <strong>{one.robot}</strong> {duration(one.recording!.length_s)}{' '}
                <span class="muted">{sizeText(one.recording!.size_bytes)}</span>
              </li>
            ))}
          </ul>
          <button type="button" class="primary" onClick={() => void stopRecording()}>
            {t('rec.stop')}
          </button>
        </div>
      ) : (
        <form
          class="record-form"
          onSubmit={(event) => {
            event.preventDefault();
            void startRecording(title.trim());
          }}
        >
          <label class="text-field">
            <span class="field-label">{t('rec.name')}</span>
            <input type="text" value={title} maxLength={32} placeholder={t('rec.name.none')} onInput={(event) => setTitle(event.currentTarget.value)} />
          </label>
          <button type="submit" class="primary record-start" disabled={wantedNow.value.size === 0}>
            <span class="recording-dot" aria-hidden="true" /> {t('rec.start')}
          </button>
          {robots.length > 1 && (
            <div class="check-joints" role="group" aria-label={t('rec.of')}>
              {robots.map(({ name }) => (
                <label key={name} class="check">
                  <input
                    type="checkbox"
                    checked={wantedNow.value.has(name)}
                    onChange={(event) => {
                      const next = new Set(wantedNow.value);
                      if (event.currentTarget.checked) next.add(name);
                      else next.delete(name);
                      wanted.value = next;
                    }}
                  />
                  {name}
                </label>
              ))}
            </div>
          )}
        </form>
      )}
      {recordsTrouble.value && (
        <p class="setup-refused" role="alert">
          {recordsTrouble.value}
        </p>
      )}
    </section>
  );
}

/** What the controller has recorded: to be played, and to be had as files. */
export function RecordsList(): JSX.Element {
  const [all, setAll] = useState(false);
  const list = records.value?.records ?? [];
  const shown = all ? list : list.slice(0, kShown);
  return (
    <section class="records-list" aria-label={t('plots.told')}>
      <h3>{t('plots.told')}</h3>
      {list.length === 0 ? (
        <p class="hint">{t('plots.told.none')}</p>
      ) : (
        <ul>
          {shown.map((one) => (
            <RecordRow key={one.record} of={one} />
          ))}
        </ul>
      )}
      {list.length > shown.length && (
        <button type="button" class="quiet" onClick={() => setAll(true)}>
          {t('rec.all', { count: list.length })}
        </button>
      )}
      {records.value?.folder && <p class="hint">{t('rec.folder', { folder: records.value.folder })}</p>}
    </section>
  );
}

function nameOf(of: KeptRecord): string {
  if (of.fault) return tWord('cause', (of.title ?? '').replace(/^fault-/, ''));
  return of.title ?? of.record;
}

function RecordRow({ of }: { of: KeptRecord }): JSX.Element {
  const [sure, setSure] = useState(false);
  const now = fetching.value?.record === of.record ? fetching.value : null;
  const facts = [
    of.began_ms !== undefined ? new Date(of.began_ms).toLocaleString(language.value, { dateStyle: 'short', timeStyle: 'short' }) : '',
    of.length_s !== undefined ? duration(of.length_s) : of.under_way ? t('rec.under_way') : t('rec.cut'),
    sizeText(of.size_bytes),
  ].filter((one) => one !== '');
  return (
    <li data-record={of.record}>
      <div class="record-what">
        <p class="record-name" title={of.record}>
          {of.robot && <strong>{of.robot}</strong>} {nameOf(of)}
          {of.fault && <span class="tag">{t('rec.fault')}</span>}
        </p>
        <p class="muted">{facts.join(' · ')}</p>
      </div>
      {now ? (
        <div class="record-do">
          <progress max={1} value={now.share} aria-label={t('rec.fetching')} />
          <IconButton icon="close" label={t('rec.give_up')} onClick={giveUp} />
        </div>
      ) : sure ? (
        <div class="record-do">
          <button type="button" class="grave" onClick={() => void removeRecord(of.record)}>
            {t('rec.remove.sure')}
          </button>
          <button type="button" class="quiet" onClick={() => setSure(false)}>
            {t('rec.remove.no')}
          </button>
        </div>
      ) : (
        <div class="record-do">
          <IconButton icon="play" label={t('rec.play', { name: of.record })} disabled={of.under_way} onClick={() => void play(of.record)} />
          <button type="button" class="quiet" title={t('rec.mcap', { name: of.record })} onClick={() => void download(of.record, 'mcap')}>
            MCAP
          </button>
          <button type="button" class="quiet" title={t('rec.csv', { name: of.record })} onClick={() => void download(of.record, 'csv')}>
            CSV
          </button>
          <IconButton icon="trash" label={t('rec.remove', { name: of.record })} disabled={of.under_way} onClick={() => setSure(true)} />
        </div>
      )}
    </li>
  );
}
