import type { ComponentChildren, JSX } from 'preact';
import { useEffect, useRef, useState } from 'preact/hooks';
import { t, tWord, type Key } from '../i18n';
import { en } from '../i18n/en';
import { model, status, store } from '../app';
import {
  checkAmount,
  checkNumber,
  checkPlace,
  kAmounts,
  rangeOf,
  stepName,
  timeLeft,
  withReason,
  type AsksJson,
  type Checked,
  type ProcedureJson,
} from '../logic/procedure';
import { jointLimits, jointsOf, positionOf } from '../logic/store';
import { duration, shown, unitOf, type Measure } from '../logic/units';
import { measuresOf } from '../shelf_state';
import { forgetOwn } from './setup_memory';
import { Icon } from './parts';

const hasText = (key: string): key is Key => key in en;

/** The step's own text, in the reader's language where it is one that this page knows. */
export function questionOf(procedure: ProcedureJson): string {
  const { key, joint } = stepName(procedure.step?.id ?? '');
  const own = `setup.ask.${key}`;
  return hasText(own) ? t(own, { joint }) : (procedure.step?.text ?? '');
}
export function stepTitle(id: string): string {
  const { key, joint } = stepName(id);
  const own = `setup.step.${key}`;
  return hasText(own) ? t(own, { joint }) : tWord('setup.step', key);
}

type Wrong = Extract<Checked, { wrong: unknown }>;
const wrongText = (checked: Wrong): string =>
  t(`setup.wrong.${checked.wrong}`, { low: checked.low ?? '', high: checked.high ?? '' });

/** What is asked, large, and its answers; while something goes on, how far it is. */
export function Question(props: { name: string; procedure: ProcedureJson; mine: boolean }): JSX.Element {
  const { name, procedure, mine } = props;
  const [refused, setRefused] = useState('');
  const [waits, setWaits] = useState(false);
  const heading = useRef<HTMLHeadingElement>(null);
  const { step, asks, progress, trouble } = procedure;
  const key = `${procedure.number}/${procedure.place}/${asks?.kind ?? ''}/${asks?.choices.join() ?? ''}`;
  const first = useRef(true);
  useEffect(() => {
    setRefused('');
    // The buttons of the question before are gone, and no Enter shall press the next one by chance.
    if (!first.current || document.activeElement === document.body) heading.current?.focus({ preventScroll: true });
    first.current = false;
  }, [key]);
  const say = async (answer: string) => {
    setWaits(true);
    setRefused('');
    const why = await store.answerProcedure(name, answer);
    setWaits(false);
    setRefused(why ?? '');
    if (why === null) heading.current?.focus({ preventScroll: true });
  };
  const can = mine && !waits;
  return (
    <section class="question" aria-label={t('setup.question')}>
      <div aria-live="polite" aria-atomic="true">
        <p class="question-step">
          {procedure.joint && <span class="joint-dot" aria-hidden="true" />}
          {step && stepTitle(step.id)}
          {procedure.joint && !step?.id.endsWith(`.${procedure.joint}`) && (
            <span class="tag tag-joint">{procedure.joint}</span>
          )}
        </p>
        <h3 class="question-text" ref={heading} tabIndex={-1}>
          {questionOf(procedure)}
        </h3>
        {procedure.joint && <p class="hint">{t('setup.marked')}</p>}
        {trouble && (
          <p class="question-trouble">
            <Icon name="fault" size={16} /> {trouble}
          </p>
        )}
      </div>
      {progress && <Progress procedure={procedure} />}
      {asks && !asks.ready && (
        <p class="hint">{t('setup.not_ready', { state: tWord('state', status.value?.state ?? '') })}</p>
      )}
      {asks && (
        <fieldset class="answers" disabled={!can || !asks.ready}>
          <legend class="sr-only">{t('setup.answers')}</legend>
          <Answers key={key} asks={asks} procedure={procedure} say={(answer) => void say(answer)} />
        </fieldset>
      )}
      {refused && (
        <p class="setup-refused" role="alert">
          {refused}
        </p>
      )}
      {mine && (
        <div class="row question-foot">
          <button
            type="button"
            disabled={waits || !asks?.ready || procedure.place === 0}
            onClick={() => void store.backProcedure(name).then((why) => setRefused(why ?? ''))}
          >
            <Icon name="back" size={16} /> {t('setup.back')}
          </button>
          <button
            type="button"
            onClick={() => {
              forgetOwn();
              void store.cancelProcedure(name).then((why) => setRefused(why ?? ''));
            }}
          >
            <Icon name="close" size={16} /> {t('setup.cancel')}
          </button>
        </div>
      )}
    </section>
  );
}

function Progress({ procedure }: { procedure: ProcedureJson }): JSX.Element {
  const progress = procedure.progress!;
  const left = timeLeft(progress, store.timeScale(procedure.robot));
  return (
    <div class="question-progress">
      <span
        class={`bar${left ? '' : ' bar-open'}`}
        role="progressbar"
        aria-label={t('setup.goes_on')}
        aria-valuemin={0}
        aria-valuemax={100}
        aria-valuenow={left ? Math.round(100 * left.share) : undefined}
      >
        <span style={{ width: left ? `${100 * left.share}%` : '35%' }} />
      </span>
      <p>
        <span>{progress.words}</span>
        {left && (
          <strong>{t(left.atMost ? 'setup.left.at_most' : 'setup.left', { time: duration(left.seconds) })}</strong>
        )}
      </p>
    </div>
  );
}

interface AnswerProps {
  asks: AsksJson;
  procedure: ProcedureJson;
  say: (answer: string) => void;
}

function Answers(props: AnswerProps): JSX.Element {
  const { asks, say } = props;
  switch (asks.kind) {
    case 'yes':
      return (
        <>
          <Choice main onClick={() => say('yes')}>
            <Icon name="check" /> {t('setup.yes')}
          </Choice>
          <Rest asks={asks} say={say} but={['yes']} />
        </>
      );
    case 'go':
      return (
        <>
          <Choice main onClick={() => say('go')}>
            <Icon name="play" /> {t('setup.go')}
          </Choice>
          <p class="hint">{t('setup.go.help')}</p>
          <Rest asks={asks} say={say} but={['go']} />
        </>
      );
    case 'words':
      return <Rest asks={asks} say={say} but={[]} />;
    case 'number':
      return <NumberAnswer {...props} />;
    case 'amount':
      return <AmountAnswer {...props} />;
    case 'place':
      return <PlaceAnswer {...props} />;
  }
}

function Choice(props: { main?: boolean; onClick: () => void; children: ComponentChildren }): JSX.Element {
  return (
    <button type="button" class={`choice${props.main ? ' primary' : ''}`} onClick={props.onClick}>
      {props.children}
    </button>
  );
}

/** Words that are no answer to what was asked, but about the asking. */
const kAside = new Set(['again', 'skip', 'nothing', 'other']);

function Rest({ asks, say, but }: { asks: AsksJson; say: (answer: string) => void; but: string[] }): JSX.Element | null {
  const rest = asks.choices.filter((one) => !but.includes(one));
  if (rest.length === 0) return null;
  const words = rest.filter((one) => !kAside.has(one));
  const aside = rest.filter((one) => kAside.has(one));
  const button = (word: string) => (
    <Choice key={word} onClick={() => say(word)}>
      {tWord('setup.word', word)}
    </Choice>
  );
  return (
    <>
      {words.length > 0 && <div class="choices">{words.map(button)}</div>}
      {aside.length > 0 && <div class="choices aside">{aside.map(button)}</div>}
    </>
  );
}

/** A field with its unit and what is wrong with it, said as soon as it is sent. */
function Field(props: {
  label: string;
  unit: string;
  button: string;
  check: (text: string) => Checked;
  say: (answer: string) => void;
}): JSX.Element {
  const [text, setText] = useState('');
  const [wrong, setWrong] = useState('');
  return (
    <form
      class="answer-field"
      noValidate
      onSubmit={(event) => {
        event.preventDefault();
        const checked = props.check(text);
        setWrong('wrong' in checked ? wrongText(checked) : '');
        if ('answer' in checked) props.say(checked.answer);
      }}
    >
      <label>
        <span class="field-label">{props.label}</span>
        <span class={`number${wrong ? ' wrong' : ''}`}>
          <input
            type="text"
            inputMode="decimal"
            autocomplete="off"
            value={text}
            aria-invalid={wrong !== ''}
            onInput={(event) => setText(event.currentTarget.value)}
          />
          <span class="unit" aria-hidden="true">
            {props.unit}
          </span>
        </span>
      </label>
      <button type="submit">{props.button}</button>
      {wrong && (
        <p class="setup-refused" role="alert">
          {wrong}
        </p>
      )}
    </form>
  );
}

function NumberAnswer({ asks, say }: AnswerProps): JSX.Element {
  const range = rangeOf(asks) ?? { measure: null, lower: 0, upper: 1e9 };
  const end = (value: number) => (range.measure ? `${shown(value, range.measure)} ${unitOf(range.measure)}` : String(value));
  return (
    <>
      <Field
        label={t('setup.number', { low: end(range.lower), high: end(range.upper) })}
        unit={range.measure ? unitOf(range.measure) : ''}
        button={t('setup.ok')}
        check={(text) => checkNumber(text, range)}
        say={say}
      />
      <Rest asks={asks} say={say} but={[]} />
    </>
  );
}

/** Of the joint that a question is about. */
const measureOf = (procedure: ProcedureJson): Measure => {
  const joints = model.value?.joints ?? [];
  const one = joints.find((joint) => joint.name === procedure.joint) ?? joints[0];
  return one?.kind === 'prismatic' ? 'length' : 'angle';
};

/** One joint by hand, by a little: steps each way, or a number; done when it stands right. */
function AmountAnswer({ asks, procedure, say }: AnswerProps): JSX.Element {
  const measure = measureOf(procedure);
  const steps = kAmounts[measure];
  const button = (sign: '+' | '-', amount: string) => (
    <button
      type="button"
      class="amount"
      key={sign + amount}
      aria-label={t('setup.amount.by', { amount: `${sign === '-' ? '−' : '+'}${amount.replace(/[a-z]+$/, ' $&')}` })}
      onClick={() => say(sign === '-' ? `-${amount}` : amount)}
    >
      {sign === '-' ? '−' : '+'}
      {parseFloat(amount)}
    </button>
  );
  return (
    <>
      <div class="amounts" role="group" aria-label={t('setup.amount', { unit: unitOf(measure) })}>
        {[...steps].reverse().map((one) => button('-', one))}
        <span aria-hidden="true">{unitOf(measure)}</span>
        {steps.map((one) => button('+', one))}
      </div>
      <Field
        label={t('setup.amount.other')}
        unit={unitOf(measure)}
        button={t('setup.amount.go')}
        check={(text) => checkAmount(text, measure)}
        say={say}
      />
      <p class="hint">{t('setup.amount.help')}</p>
      <Choice main onClick={() => say('done')}>
        <Icon name="check" /> {t('setup.amount.done')}
      </Choice>
      <Rest asks={asks} say={say} but={[]} />
    </>
  );
}

/** Where it stands: named places, or a value a joint; and why, where somebody has moved it. */
function PlaceAnswer({ asks, say }: AnswerProps): JSX.Element {
  const one = model.value;
  const joints = one?.joints ?? [];
  const measures = one ? measuresOf(one) : [];
  const known = jointsOf(status.value, positionOf);
  const [values, setValues] = useState<string[]>(() =>
    joints.map((joint, i) => shown(known?.[i] ?? jointLimits(joint).home, measures[i]!)),
  );
  const [moved, setMoved] = useState('');
  const [wrong, setWrong] = useState('');
  return (
    <>
      <label class="answer-reason">
        <span class="field-label">{t('setup.place.moved')}</span>
        <input type="text" maxLength={120} value={moved} onInput={(event) => setMoved(event.currentTarget.value)} />
      </label>
      <div class="choices">
        {asks.choices.map((word) => (
          <Choice key={word} onClick={() => say(word === 'skip' ? word : withReason(word, moved))}>
            {tWord('setup.place', word)}
          </Choice>
        ))}
      </div>
      <details class="answer-values">
        <summary>{t('setup.place.values')}</summary>
        <form
          noValidate
          onSubmit={(event) => {
            event.preventDefault();
            const checked = checkPlace(values, measures, moved);
            setWrong('wrong' in checked ? wrongText(checked) : '');
            if ('answer' in checked) say(checked.answer);
          }}
        >
          {joints.map((joint, i) => (
            <label key={joint.name}>
              <span>{joint.name}</span>
              <span class="number">
                <input
                  type="text"
                  inputMode="decimal"
                  value={values[i]}
                  onInput={(event) => setValues(values.map((each, k) => (k === i ? event.currentTarget.value : each)))}
                />
                <span class="unit" aria-hidden="true">
                  {unitOf(measures[i]!)}
                </span>
              </span>
            </label>
          ))}
          {wrong && (
            <p class="setup-refused" role="alert">
              {wrong}
            </p>
          )}
          <button type="submit">{t('setup.place.there')}</button>
        </form>
      </details>
    </>
  );
}
