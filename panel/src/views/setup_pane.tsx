import { isPlaceKnown } from '../logic/store';
import type { JSX } from 'preact';
import { useSignal, useSignalEffect } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { t, tWord } from '../i18n';
import { model, robot, status, store } from '../app';
import { kProcedures, wasCutOff, type ProcedureJson, type ProcedureKind } from '../logic/procedure';
import { look, meantJoint } from '../scene_state';
import { forgetOwn, isOwn, keepOwn } from './setup_memory';
import { Icon } from './parts';
import { SettingsForm } from './settings_form';
import { SetupFacts } from './setup_facts';
import { Question } from './setup_question';
import { ResultCard, StepList } from './setup_steps';

/** Homing, recovery, commissioning: what the controller asks, step by step, and what it found. */
export function SetupPane(): JSX.Element {
  const name = robot.value;
  useSignalEffect(() => {
    const at = robot.value;
    const one = at ? store.procedures.value[at] : undefined;
    const joints = model.value?.joints ?? [];
    const joint = one && !one.over && one.joint ? joints.findIndex((each) => each.name === one.joint) : -1;
    const before = meantJoint.peek();
    if (joint < 0 || !at) meantJoint.value = null;
    else if (before?.robot !== at || before.joint !== joint) meantJoint.value = { robot: at, joint };
  });
  useEffect(() => () => void (meantJoint.value = null), []);
  if (!name) return <p class="empty">{t('robot.pick')}</p>;
  const one = store.procedures.value[name];
  return (
    <div class="pane-body setup" data-tour="setup" key={name}>
      {one && !one.over ? <UnderWay name={name} procedure={one} /> : <Choose name={name} last={one} />}
    </div>
  );
}

function UnderWay({ name, procedure }: { name: string; procedure: ProcedureJson }): JSX.Element {
  const mine = store.ownsProcedure(name);
  const viewer = store.role.value === 'viewer';
  const goOn = async () => {
    const why = await store.startProcedure(name, procedure.kind as ProcedureKind, { take_over: store.lease(name) === 'other' });
    if (why === null) keepOwn(store.procedures.value[name]!);
    else if (why !== '') store.note('refused', why, name);
  };
  return (
    <>
      <header class="setup-head">
        <h2>{tWord('procedure', procedure.kind)}</h2>
        <span>
          {name}
          {procedure.step && ` · ${t('setup.step', { number: procedure.step.number, of: procedure.step.of })}`}
        </span>
      </header>
      <span
        class="bar setup-bar"
        role="progressbar"
        aria-label={t('setup.progress')}
        aria-valuemin={0}
        aria-valuemax={procedure.steps.length}
        aria-valuenow={procedure.place}
      >
        <span style={{ width: `${(100 * procedure.place) / Math.max(1, procedure.steps.length)}%` }} />
      </span>
      {!mine && (
        <div class="callout">
          <p>{t(procedure.client_lost ? 'setup.waits' : 'setup.other')}</p>
          <div class="row">
            <button type="button" class={procedure.client_lost ? 'primary' : ''} disabled={viewer} onClick={() => void goOn()}>
              {t(procedure.client_lost ? 'setup.waits.go_on' : 'setup.other.take')}
            </button>
            {procedure.client_lost && (
              <button type="button" disabled={viewer} onClick={() => void store.cancelProcedure(name)}>
                {t('setup.waits.end')}
              </button>
            )}
          </div>
        </div>
      )}
      <Question name={name} procedure={procedure} mine={mine} />
      <StepList procedure={procedure} />
    </>
  );
}

const kIcons = { home: 'home', recover: 'reset', commission: 'setup' } as const;

function Choose({ name, last }: { name: string; last: ProcedureJson | undefined }): JSX.Element {
  const refused = useSignal<{ kind: ProcedureKind; why: string } | null>(null);
  const starting = useSignal(false);
  const now = status.value;
  const lease = store.lease(name);
  const place = store.robots.value.find((one) => one.name === name);
  const busy = now?.job ? !now.job.over : false;
  const barred = busy || store.role.value === 'viewer';
  const cutOff = wasCutOff(last, false) && isOwn(last!);
  const advised: ProcedureKind | null =
    now && now.state !== 'off' && !isPlaceKnown(now) ? 'recover' : null;
  const start = async (kind: ProcedureKind, anew = false) => {
    starting.value = true;
    refused.value = null;
    const why = await store.startProcedure(name, kind, {
      ...(store.lease(name) === 'other' ? { take_over: true } : {}),
      ...(anew ? { anew: true } : {}),
    });
    starting.value = false;
    if (why !== null) {
      if (why !== '') refused.value = { kind, why };
      return;
    }
    keepOwn(store.procedures.value[name]!);
    look.value = { preset: look.value.preset, all: false };
  };
  return (
    <>
      {cutOff && last && (
        <div class="callout" role="status">
          <p>
            <strong>{t('setup.cut', { title: tWord('procedure', last.kind) })}</strong>
          </p>
          <p>{t(last.kind === 'commission' ? 'setup.cut.kept' : 'setup.cut.anew')}</p>
          <div class="row">
            <button type="button" class="primary" disabled={starting.value} onClick={() => void start(last.kind as ProcedureKind)}>
              <Icon name="play" size={15} /> {t('setup.go_on')}
            </button>
            <button
              type="button"
              onClick={() => {
                forgetOwn();
                refused.value = null;
                store.procedures.value = { ...store.procedures.value };
              }}
            >
              {t('setup.leave')}
            </button>
          </div>
        </div>
      )}
      {last && last.number > 0 && !cutOff && <ResultCard procedure={last} />}
      {place?.position_journal && (
        <div class="callout">
          <p>{t('recover.found', { text: place.position_journal.found })}</p>
          <p>{t('recover.way_out', { text: place.position_journal.way_out })}</p>
        </div>
      )}
      <ul class="setup-kinds">
        {kProcedures.map((kind) => (
          <li key={kind} class={`setup-kind${advised === kind ? ' advised' : ''}`}>
            <Icon name={kIcons[kind]} size={22} />
            <div>
              <h3>
                {t(`procedure.${kind}`)}
                {advised === kind && <span class="tag">{t('setup.advised')}</span>}
              </h3>
              <p>{t(`setup.about.${kind}`)}</p>
              {refused.value?.kind === kind && (
                <p class="setup-refused" role="alert">
                  {refused.value.why}
                </p>
              )}
              <div class="row">
                <button
                  type="button"
                  class={advised === kind ? 'primary' : ''}
                  disabled={starting.value || barred}
                  title={lease === 'other' ? t('lease.take_over.title') : undefined}
                  onClick={() => void start(kind)}
                >
                  {t(lease === 'other' ? 'setup.start.take_over' : `setup.start.${kind}`)}
                </button>
                {kind === 'commission' && (
                  <button type="button" class="quiet" disabled={starting.value || barred} onClick={() => void start(kind, true)}>
                    {t('setup.start.anew')}
                  </button>
                )}
              </div>
            </div>
          </li>
        ))}
      </ul>
      {busy && <p class="hint">{t('setup.busy')}</p>}
      <SettingsForm name={name} />
      {place && <SetupFacts place={place} last={last} />}
    </>
  );
}
