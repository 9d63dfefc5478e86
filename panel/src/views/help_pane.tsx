import type { JSX } from 'preact';
import { useSignal } from '@preact/signals';
import { language, t, type Key } from '../i18n';
import { model, robot, store } from '../app';
import { robotsDe } from '../i18n/robots_de';
import { robotsEn, type RobotHelp } from '../i18n/robots_en';
import { dependencies } from '../../package.json';
import { kProgramParts, kSinewLicence, pageParts, type Part } from '../logic/licences';
import { Icon, Segments } from './parts';
import { showTour } from './tour';

const kRobots: Record<typeof language.value, Record<string, RobotHelp>> = { en: robotsEn, de: robotsDe };
type Tab = 'robot' | 'use' | 'about';

export function HelpPane(): JSX.Element {
  const tab = useSignal<Tab>('robot');
  return (
    <div class="pane-body help" data-tour="help">
      <Segments
        hideLabel
        label={t('view.help')}
        value={tab.value}
        options={(['robot', 'use', 'about'] as const).map((value) => ({ value, text: t(`help.tab.${value}`) }))}
        onChange={(value) => (tab.value = value)}
      />
      {tab.value === 'robot' ? <RobotPage /> : tab.value === 'use' ? <UsePage /> : <AboutPage />}
      <button type="button" class="tour-again" onClick={showTour}>
        <Icon name="help" /> {t('help.tour')}
      </button>
    </div>
  );
}

function RobotPage(): JSX.Element {
  const one = model.value;
  const page = one ? kRobots[language.value][one.robot] : undefined;
  if (!one || !page) return <p class="empty">{t(one ? 'help.none' : 'robot.pick')}</p>;
  const here = store.robots.value.find((place) => place.name === robot.value);
  return (
    <article class="robot-page">
      <h2>{one.title}</h2>
      <p class="callout">
        {t('help.not_tried')} {here && t(here.simulated ? 'help.now.simulated' : 'help.now.real')}
      </p>
      <section>
        <h3>{t('help.wiring')}</h3>
        <dl class="facts">
          {page.wiring.map(([name, text]) => (
            <div key={name}>
              <dt>{name}</dt>
              <dd>{text}</dd>
            </div>
          ))}
        </dl>
      </section>
      <List title="help.before" rows={page.before} mark="fault" />
      <List title="help.works" rows={page.works} mark="check" />
      <List title="help.simulated" rows={page.simulated} mark="branch" />
      <section>
        <h3>{t('help.position')}</h3>
        <p>{page.position}</p>
      </section>
      <section>
        <h3>{t('help.stops')}</h3>
        <p>{page.stops}</p>
      </section>
    </article>
  );
}

function List(props: { title: Key; rows: string[]; mark: 'fault' | 'check' | 'branch' }): JSX.Element | null {
  if (props.rows.length === 0) return null;
  return (
    <section>
      <h3>{t(props.title)}</h3>
      <ul class={`marks marks-${props.mark}`}>
        {props.rows.map((row) => (
          <li key={row}>
            <Icon name={props.mark} size={15} />
            <span>{row}</span>
          </li>
        ))}
      </ul>
    </section>
  );
}

function UsePage(): JSX.Element {
  const keys: [string[], Key][] = [
    [['Esc', t('help.key.space')], 'help.key.stop'],
    [['Enter'], 'help.key.enter'],
    [['Tab'], 'help.key.tab'],
    [[t('help.key.arrows')], 'help.key.grip'],
    [[t('help.key.arrows'), '1–6'], 'help.key.jog'],
  ];
  return (
    <article class="robot-page">
      <p class="callout grave">{t('help.stop')}</p>
      <dl class="facts keys">
        {keys.map(([names, text]) => (
          <div key={text}>
            <dt>
              {names.map((one) => (
                <kbd key={one}>{one}</kbd>
              ))}
            </dt>
            <dd>{t(text)}</dd>
          </div>
        ))}
      </dl>
      <h3>{t('help.words')}</h3>
      <dl class="facts">
        {(['control', 'measured', 'commanded', 'lost'] as const).map((word) => (
          <div key={word}>
            <dt>{t(`help.word.${word}`)}</dt>
            <dd>{t(`help.word.${word}.text`)}</dd>
          </div>
        ))}
      </dl>
    </article>
  );
}

function AboutPage(): JSX.Element {
  return (
    <article class="robot-page about">
      <h2>Sinew</h2>
      <p>{t('about.what')}</p>
      <p class="about-version">
        {t('about.version', { version: store.cell.value?.version ?? '?' })}
        <span>
          {t('about.licence')} {kSinewLicence}
        </span>
      </p>
      <Parts title="about.program" parts={kProgramParts} />
      <Parts title="about.page" parts={pageParts(dependencies)} />
    </article>
  );
}

function Parts({ title, parts }: { title: Key; parts: readonly Part[] }): JSX.Element {
  return (
    <section>
      <h3>{t(title)}</h3>
      <ul class="licences">
        {parts.map((one) => (
          <li key={one.name}>
            <strong>{one.name}</strong>
            <span class="muted">{one.version}</span>
            <span>{one.licence}</span>
            {one.text && (
              <details>
                <summary>{t('about.text')}</summary>
                <pre tabIndex={0}>{one.text}</pre>
              </details>
            )}
          </li>
        ))}
      </ul>
    </section>
  );
}
