import type { JSX } from 'preact';
import { useEffect, useRef, useState } from 'preact/hooks';
import { t, tWord } from '../i18n';
import { rpc, status } from '../app';
import { notKept } from '../logic/kept';
import { Latest } from '../logic/latest';
import {
  jointsOf,
  kSimulated,
  sameSettings,
  settingsText,
  trimOf,
  trimText,
  withFound,
  withSetting,
  type Settings,
  type SettingsJson,
  type SettingsVerdict,
} from '../logic/settings';
import { Icon } from './parts';

const kCheckMs = 250;

/** What this robot runs with from the next start on: looked at while it is typed, kept beside the cell's file. */
export function SettingsForm({ name }: { name: string }): JSX.Element | null {
  const [told, setTold] = useState<SettingsJson | null>(null);
  const [draft, setDraft] = useState<Settings>({});
  const [verdict, setVerdict] = useState<SettingsVerdict | null>(null);
  const [note, setNote] = useState<{ text: string; grave: boolean } | null>(null);
  const open = useRef(false);
  const take = (json: SettingsJson) => {
    setTold(json);
    setDraft(json.now);
    setVerdict(null);
  };
  const load = () =>
    rpc.call<SettingsJson>('settings.get', { robot: name }).then(take, (error: unknown) => {
      const why = notKept(error);
      setNote(why.why === 'refused' ? { text: why.sentence, grave: true } : null);
    });
  const asking = useRef<Latest<Settings, SettingsVerdict> | null>(null);
  asking.current ??= new Latest<Settings, SettingsVerdict>({
    intervalMs: kCheckMs,
    ask: (settings) => rpc.call<SettingsVerdict>('settings.check', { robot: name, settings }),
    onAnswer: (_, answer) => setVerdict(answer),
    onError: () => setVerdict(null),
  });
  const kept = status.value?.kept;
  const changed = told !== null && !sameSettings(draft, told.now);
  useEffect(() => {
    if (open.current && !changed) void load();
  }, [kept]);
  useEffect(() => () => asking.current?.forget(), []);
  const put = (next: Settings) => {
    setDraft(next);
    setNote(null);
    asking.current?.put(next);
  };
  const save = async (settings: Settings, on = told) => {
    if (!on) return;
    try {
      const json = await rpc.call<SettingsJson>('settings.set', { robot: name, settings, revision: on.revision });
      asking.current?.forget();
      take(json);
      setNote({ text: t('set.saved', { file: json.file }), grave: false });
    } catch (error) {
      const why = notKept(error);
      if (why.why === 'conflict') return overtaken(settings, on);
      setNote({ text: why.why === 'refused' ? why.sentence : t('set.lost'), grave: true });
    }
  };
  /** One file has the settings of all robots. What somebody set of another one is no matter here. */
  const overtaken = async (settings: Settings, on: SettingsJson): Promise<void> => {
    const theirs = await rpc.call<SettingsJson>('settings.get', { robot: name }).catch(() => null);
    if (!theirs) return setNote({ text: t('set.lost'), grave: true });
    if (sameSettings(theirs.now, on.now) && theirs.revision !== on.revision) return save(settings, theirs);
    // What was to be saved stays in the form; behind it now stands what they have set.
    setTold(theirs);
    setNote({ text: t('set.conflict', { what: settingsText(theirs.now) }), grave: true });
  };
  const wrong = (key: string) => (changed ? verdict?.complaints.find((one) => one.name === key)?.sentence : undefined);
  return (
    <details
      class="setup-facts settings"
      onToggle={(event) => {
        open.current = event.currentTarget.open;
        if (open.current && !told) void load();
      }}
    >
      <summary>{t('set.title')}</summary>
      {told && (
        <form
          onSubmit={(event) => {
            event.preventDefault();
            void save(draft);
          }}
        >
          <p class="hint">{t('set.about')}</p>
          <PlaceFields told={told} draft={draft} profiles={verdict?.profiles ?? told.profiles} wrong={wrong} put={put} />
          <JointFields told={told} draft={draft} wrong={wrong} put={put} />
          {wrong('') && <p class="setup-refused">{wrong('')}</p>}
          <div class="row settings-do">
            <button type="submit" class="primary" disabled={!changed || verdict?.fine === false}>
              <Icon name="check" size={16} /> {t('set.save')}
            </button>
            <button
              type="button"
              disabled={!changed}
              onClick={() => {
                asking.current?.forget();
                setVerdict(null);
                setDraft(told.now);
                setNote(null);
              }}
            >
              {t('set.revert')}
            </button>
            {told.found && !sameSettings(withFound(draft, told.found), draft) && (
              <button type="button" class="quiet" onClick={() => put(withFound(draft, told.found!))}>
                {t('set.found')}
              </button>
            )}
            {told.is_set && !changed && (
              <button type="button" class="quiet" onClick={() => void save({})}>
                {t('set.own')}
              </button>
            )}
          </div>
          {note && (
            <p class={note.grave ? 'setup-refused' : 'settings-note'} role={note.grave ? 'alert' : 'status'}>
              {note.text}
            </p>
          )}
          {told.restart && !changed && <p class="callout settings-restart">{t('set.restart')}</p>}
        </form>
      )}
      {!told && note && <p class="setup-refused">{note.text}</p>}
    </details>
  );
}

interface Fields {
  told: SettingsJson;
  draft: Settings;
  wrong: (name: string) => string | undefined;
  put: (next: Settings) => void;
}

function Wrong({ text }: { text: string | undefined }): JSX.Element | null {
  return text ? (
    <p class="wrong-words" role="alert">
      {text}
    </p>
  ) : null;
}

function PlaceFields({ told, draft, profiles, wrong, put }: Fields & { profiles: string[] }): JSX.Element {
  const simulated = draft['port'] === kSimulated;
  const last = useRef('');
  if (!simulated) last.current = draft['port'] ?? '';
  return (
    <div class="settings-place">
      <label class="check">
        <input
          type="checkbox"
          checked={simulated}
          onChange={(event) => put({ ...draft, port: event.currentTarget.checked ? kSimulated : last.current || '/dev/ttyUSB0' })}
        />
        {t('set.simulated')}
      </label>
      {!simulated && (
        <label class="text-field">
          <span class="field-label">{t('set.port')}</span>
          <input
            type="text"
            value={draft['port'] ?? ''}
            maxLength={1024}
            spellcheck={false}
            autocomplete="off"
            aria-invalid={!!wrong('port')}
            onInput={(event) => put({ ...draft, port: event.currentTarget.value })}
          />
        </label>
      )}
      <Wrong text={wrong('port')} />
      {(['wire', 'profile'] as const).map((which) => {
        const names = which === 'wire' ? told.wires : profiles;
        if (names.length < 2) return null;
        const now = draft[which] ?? '';
        return (
          <label key={which} class="text-field">
            <span class="field-label">{t(`set.${which}`)}</span>
            <select value={now} aria-invalid={!!wrong(which)} onChange={(event) => put({ ...draft, [which]: event.currentTarget.value })}>
              {(names.includes(now) ? names : [now, ...names]).map((one) => (
                <option key={one}>{one}</option>
              ))}
            </select>
            <Wrong text={wrong(which)} />
          </label>
        );
      })}
    </div>
  );
}

function JointFields({ told, draft, wrong, put }: Fields): JSX.Element | null {
  const joints = jointsOf(told.settable);
  const extra = told.settable.filter((one) => !one.startsWith('joint.'));
  if (joints.length === 0 && extra.length === 0) return null;
  const columns = ['turn', 'trim_rad', 'servo_id'].filter((one) => joints.some(({ can }) => can.includes(one)));
  return (
    <>
      {joints.length > 0 && (
        <table class="settings-joints">
          <thead>
            <tr>
              <th scope="col">{t('setup.facts.joint')}</th>
              {columns.map((one) => (
                <th key={one} scope="col">
                  {tWord('set.column', one)}
                </th>
              ))}
            </tr>
          </thead>
          <tbody>
            {joints.map(({ joint, can }) => (
              <tr key={joint}>
                <th scope="row">{joint}</th>
                {columns.map((what) => (
                  <td key={what}>{can.includes(what) && <JointField name={`joint.${joint}.${what}`} {...{ told, draft, wrong, put }} />}</td>
                ))}
              </tr>
            ))}
          </tbody>
        </table>
      )}
      {extra.map((one) => (
        <label key={one} class="text-field">
          <span class="field-label">{tWord('set.column', one)}</span>
          {one.endsWith('turn') ? (
            <input
              type="checkbox"
              checked={draft[one] === 'other'}
              onChange={(event) => put(withSetting(draft, one, event.currentTarget.checked ? 'other' : null))}
            />
          ) : (
            <TextSetting name={one} {...{ told, draft, wrong, put }} />
          )}
        </label>
      ))}
    </>
  );
}

function JointField(props: Fields & { name: string }): JSX.Element {
  const { name, draft, put } = props;
  const [, joint, what] = name.split('.');
  if (what !== 'turn') return <TextSetting {...props} />;
  return (
    <input
      type="checkbox"
      aria-label={t('set.field', { joint: joint!, what: tWord('set.column', what) })}
      checked={draft[name] === 'other'}
      onChange={(event) => put(withSetting(draft, name, event.currentTarget.checked ? 'other' : null))}
    />
  );
}

/** Shown as it is typed until it is left. */
function TextSetting({ name, draft, wrong, put }: Fields & { name: string }): JSX.Element {
  const [typed, setTyped] = useState<string | null>(null);
  const [, joint, what] = name.split('.');
  const trim = what === 'trim_rad';
  const kept = trim ? trimText(draft[name]) : (draft[name] ?? '');
  const bad = wrong(name);
  return (
    <>
      <span class={`number${bad ? ' wrong' : ''}`}>
        <input
          type="text"
          inputMode="decimal"
          aria-label={what ? t('set.field', { joint: joint!, what: tWord('set.column', what) }) : tWord('set.column', name)}
          aria-invalid={!!bad}
          placeholder={trim ? '0' : '–'}
          value={typed ?? kept}
          onInput={(event) => {
            const text = event.currentTarget.value;
            setTyped(text);
            put(withSetting(draft, name, trim ? trimOf(text) : text.trim() || null));
          }}
          onBlur={() => setTyped(null)}
        />
        {trim && (
          <span class="unit" aria-hidden="true">
            °
          </span>
        )}
      </span>
      <Wrong text={bad} />
    </>
  );
}
