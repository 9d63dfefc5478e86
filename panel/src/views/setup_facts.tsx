import type { JSX } from 'preact';
import { t } from '../i18n';
import { model } from '../app';
import type { ProcedureJson } from '../logic/procedure';
import { jointLimits } from '../logic/store';
import type { CellRobot, JointJson } from '../logic/types';
import { shown, unitOf } from '../logic/units';

/** What this robot runs with: read here, changed in the cell's file and by commissioning. */
export function SetupFacts({ place, last }: { place: CellRobot; last: ProcedureJson | undefined }): JSX.Element {
  const one = model.value;
  return (
    <details class="setup-facts">
      <summary>{t('setup.facts')}</summary>
      <dl class="facts">
        <Fact name={t('setup.facts.robot')} value={`${place.title} (${place.robot})`} />
        <Fact name={t('setup.facts.port')} value={place.simulated ? `${place.port}, ${t('app.simulated')}` : place.port} />
        <Fact name={t('setup.facts.motion')} value={t(place.streams ? 'setup.facts.streams' : 'setup.facts.whole')} />
        {place.stop && <Fact name={t('setup.facts.stop')} value={place.stop.standstill} />}
        {place.stop && <Fact name={t('setup.facts.gravity')} value={place.stop.gravity} />}
        <Fact name={t('setup.facts.settings')} value={last?.file ?? t('setup.facts.settings.none')} />
      </dl>
      {one && (
        <table>
          <thead>
            <tr>
              <th scope="col">{t('setup.facts.joint')}</th>
              <th scope="col">{t('setup.facts.from')}</th>
              <th scope="col">{t('setup.facts.to')}</th>
              <th scope="col">{t('setup.facts.home')}</th>
            </tr>
          </thead>
          <tbody>
            {one.joints.map((joint) => (
              <JointRow key={joint.name} joint={joint} />
            ))}
          </tbody>
        </table>
      )}
      <p class="hint">{t('setup.facts.help')}</p>
    </details>
  );
}

function JointRow({ joint }: { joint: JointJson }): JSX.Element {
  const { lower, upper, home, measure } = jointLimits(joint);
  const text = (value: number) => `${shown(value, measure)} ${unitOf(measure)}`;
  return (
    <tr>
      <th scope="row">{joint.name}</th>
      <td>{text(lower)}</td>
      <td>{text(upper)}</td>
      <td>{text(home)}</td>
    </tr>
  );
}

function Fact({ name, value }: { name: string; value: string }): JSX.Element {
  return (
    <div>
      <dt>{name}</dt>
      <dd>{value}</dd>
    </div>
  );
}
