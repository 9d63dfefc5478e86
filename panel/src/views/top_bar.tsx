import type { JSX } from 'preact';
import { language, t } from '../i18n';
import { languages, setLanguage, setStopKeys, setTheme, stop, stopKeys, store, theme } from '../app';
import { age } from '../logic/units';
import { Icon } from './parts';

/** The mark of the house, the cell, what is always at hand, and Stop. */
export function TopBar(): JSX.Element {
  const cell = store.cell.value;
  const connection = store.connection.value;
  const silent = connection === 'open' && store.age.value !== null;
  const simulated = cell?.robots.every((one) => one.simulated) ?? false;
  const other = theme.value === 'dark' ? 'light' : 'dark';
  const toTheme = t('app.theme.switch', { theme: t(`app.theme.${other}`) });
  return (
    <header class="top">
      <div class="brand">
        <svg width="30" height="30" viewBox="0 0 32 32" aria-hidden="true">
          <path class="brand-arm" d="M8 24 13 12 22 9" />
          <circle class="brand-joint" cx="8" cy="24" r="3" />
          <circle class="brand-joint" cx="13" cy="12" r="2.6" />
          <circle class="brand-tip" cx="22.5" cy="9" r="2.4" />
        </svg>
        <div>
          <h1>{cell?.title ?? 'Sinew'}</h1>
          <p class="brand-sub">
            <span class={`link link-${silent ? 'lost' : connection}`} role="status">
              {silent ? t('connection.silent', { age: age(store.age.value!) }) : t(`connection.${connection}`)}
            </span>
            {store.role.value === 'viewer' && <span>{t('role.viewer')}</span>}
            {simulated && <span>{t('app.simulated')}</span>}
          </p>
        </div>
      </div>
      {store.demonstration.value && (
        <div class="demonstration" role="status">
          <span>{t('demonstration.runs')}</span>
          <button type="button" onClick={() => void store.ask('robot.stop', {})}>
            {t('demonstration.end')}
          </button>
        </div>
      )}
      <div class="top-tools">
        <button
          type="button"
          class="quiet"
          aria-pressed={stopKeys.value}
          title={t(stopKeys.value ? 'app.stop_keys.on' : 'app.stop_keys.off')}
          onClick={() => setStopKeys(!stopKeys.value)}
        >
          <Icon name="keyboard" />
          <span class="sr-only">{t(stopKeys.value ? 'app.stop_keys.on' : 'app.stop_keys.off')}</span>
        </button>
        <button type="button" class="quiet" title={toTheme} aria-label={toTheme} onClick={() => setTheme(other)}>
          <Icon name={other === 'light' ? 'sun' : 'moon'} />
        </button>
        <select
          class="quiet"
          aria-label={t('app.language')}
          value={language.value}
          onChange={(event) => setLanguage(event.currentTarget.value as typeof language.value)}
        >
          {languages.map(([code, { name }]) => (
            <option key={code} value={code}>
              {name}
            </option>
          ))}
        </select>
        <button type="button" class="stop" data-tour="stop" title={t('stop.title')} onClick={stop}>
          <Icon name="stop" size={22} />
          {t('stop.button')}
        </button>
      </div>
    </header>
  );
}
