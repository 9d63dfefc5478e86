import type { JSX } from 'preact';
import { useRef, useState } from 'preact/hooks';
import { errorSentence, t, tWord } from '../i18n';
import { model, standing, store } from '../app';
import { insertRows, lastOf, moveRow, readRows, rowCount, stepRow, type Row } from '../logic/rows';
import { newRows, wordsOf, type Word } from '../logic/row_kinds';
import { timeSpan } from '../logic/units';
import type { RowVerdict } from '../logic/verdicts';
import { edit, failedLine, job, runningLine, say, selected, shelf, text, verdicts } from '../teach';
import { Icon, type IconName } from './parts';
import { whyText } from './program_verdict';
import { RowFields } from './row_fields';

const kIcons: Record<string, IconName> = {
  joint: 'joint',
  move: 'move',
  line: 'line',
  arc: 'arc',
  spline: 'spline',
  home: 'home',
  jaws: 'grab',
  gripper: 'grab',
  suction: 'grab',
  nozzle: 'reset',
  wait: 'wait',
  loop: 'loop',
  if: 'branch',
  repeat: 'loop',
  look: 'eye',
  pick: 'grab',
  place: 'pin',
  call: 'call',
};

const kEdge = 36; // px
const kScroll = 10; // px, each 30 ms

/** What has to be scrolled to see more of it. */
function scrolled(element: HTMLElement): HTMLElement {
  for (let at: HTMLElement | null = element; at; at = at.parentElement) {
    if (at.scrollHeight > at.clientHeight && /auto|scroll/.test(getComputedStyle(at).overflowY)) return at;
  }
  return document.documentElement;
}

/** One row of the text, one step: chosen to be filled in, dragged by its handle or with the arrow keys. */
export function Timeline(): JSX.Element {
  const list = useRef<HTMLOListElement>(null);
  const [drop, setDrop] = useState<{ line: number; before: number } | null>(null);
  const { rows } = readRows(text.value);
  const shown = rows.filter((row) => row.word !== '' || row.remark !== '');

  /** The line before which a row would be let go. */
  const under = (y: number): number => {
    for (const item of list.current!.querySelectorAll<HTMLElement>('li[data-line]')) {
      const box = item.querySelector('.step-row')!.getBoundingClientRect();
      if (y < box.top + box.height / 2) return Number(item.dataset['line']);
    }
    return rowCount(text.peek()) + 1;
  };
  const grab = (event: PointerEvent, line: number) => {
    const handle = event.currentTarget as HTMLElement;
    handle.setPointerCapture(event.pointerId);
    setDrop({ line, before: line });
    let y = event.clientY;
    const move = (now: PointerEvent) => {
      y = now.clientY;
      setDrop({ line, before: under(y) });
    };
    // Held at the edge of what is seen, the list goes on.
    const pane = scrolled(list.current!);
    const timer = setInterval(() => {
      if (!handle.isConnected) return clearInterval(timer);
      const { top, bottom } = pane.getBoundingClientRect();
      const step = y < top + kEdge ? -kScroll : y > bottom - kEdge ? kScroll : 0;
      const before = pane.scrollTop;
      pane.scrollTop += step;
      if (pane.scrollTop !== before) setDrop({ line, before: under(y) });
    }, 30);
    const end = (now: PointerEvent) => {
      clearInterval(timer);
      for (const [kind, listener] of listeners) handle.removeEventListener(kind, listener as EventListener);
      setDrop(null);
      if (now.type !== 'pointerup') return;
      const change = moveRow(text.peek(), line, under(now.clientY));
      if (change) moved(change);
    };
    const listeners = [['pointermove', move], ['pointerup', end], ['pointercancel', end]] as const;
    for (const [kind, listener] of listeners) handle.addEventListener(kind, listener as EventListener);
  };
  const moved = (change: { text: string; line: number }) => {
    edit(change.text, change.line);
    say('prog.moved', { line: change.line });
  };
  const onKey = (event: KeyboardEvent, line: number) => {
    const way = ({ ArrowUp: -1, ArrowDown: 1 } as const)[event.key];
    if (!way) return;
    event.preventDefault();
    event.stopPropagation();
    const change = stepRow(text.peek(), line, way);
    if (!change) return;
    moved(change);
    requestAnimationFrame(() =>
      list.current?.querySelector<HTMLElement>(`li[data-line="${change.line}"] .grip`)?.focus(),
    );
  };
  return (
    <section class="timeline" aria-label={t('prog.form.rows')}>
      <ol class="steps" ref={list} data-dragging={drop ? 'true' : undefined}>
        {shown.map((row) => (
          <Step
            key={row.line}
            row={row}
            last={lastOf({ rows, whole: true }, row.line)}
            drop={drop?.before === row.line && drop.line !== row.line}
            dragged={drop?.line === row.line}
            onGrab={grab}
            onKey={onKey}
          />
        ))}
        <li class={`steps-end${drop && drop.before > (shown.at(-1)?.line ?? 0) ? ' drop' : ''}`} aria-hidden="true" />
      </ol>
      {shown.length === 0 && <p class="empty">{t('prog.none')}</p>}
      <AddStep />
      <p class="sr-only" id="grip-help">
        {t('prog.grip.help')}
      </p>
    </section>
  );
}

function Step(props: {
  row: Row;
  last: number;
  drop: boolean;
  dragged: boolean;
  onGrab: (event: PointerEvent, line: number) => void;
  onKey: (event: KeyboardEvent, line: number) => void;
}): JSX.Element {
  const { row } = props;
  const told = verdicts.value[row.line];
  const runs = runningLine.value === row.line;
  const failed = failedLine.value === row.line;
  const open = selected.value === row.line && row.word !== '';
  const lasting = row.word === 'else' || row.word === 'end';
  return (
    <li
      class={`step${props.drop ? ' drop' : ''}${props.dragged ? ' dragged' : ''}`}
      data-line={row.line}
      data-verdict={told?.verdict}
      data-running={runs ? 'true' : undefined}
      data-open={open ? 'true' : undefined}
      style={{ '--depth': row.depth } as JSX.CSSProperties}
    >
      <div class="step-row">
        {row.word !== 'else' ? (
          <button
            type="button"
            class="quiet grip"
            aria-label={t('prog.grip', { line: row.line })}
            aria-describedby="grip-help"
            onPointerDown={(event) => props.onGrab(event, row.line)}
            onKeyDown={(event) => props.onKey(event, row.line)}
          >
            <Icon name="grip" size={16} />
          </button>
        ) : (
          <span class="grip" />
        )}
        {row.word === '' ? (
          <p class="step-remark">{row.remark}</p>
        ) : (
          <button
            type="button"
            class="step-face"
            aria-expanded={open}
            aria-current={runs ? 'step' : undefined}
            onClick={() => (selected.value = open ? null : row.line)}
          >
            <span class="step-line">{row.line}</span>
            {!lasting && <Icon name={kIcons[row.word] ?? 'fault'} size={16} />}
            <span class="step-text">
              <strong>{row.word}</strong> {row.tokens.slice(1).join(' ')}
              {row.remark && <span class="step-remark"> {row.remark}</span>}
            </span>
            {told && <TimeOf told={told} />}
            {told && <Mark told={told} />}
            {runs && <span class="sr-only">{t('prog.row.runs')}</span>}
          </button>
        )}
      </div>
      {failed && job.value?.error ? (
        <p class="step-why">{errorSentence(job.value.error)}</p>
      ) : (
        told && (told.why || typeof told.because === 'object') && (
          <p class={`step-why ${told.verdict}`}>{told.why ? whyText(told.why) : blindText(told)}</p>
        )
      )}
      {open && <RowFields key={row.line} row={row} last={props.last} />}
    </li>
  );
}

/** Of a motion that begins with this row; one that goes on with another row has no time of its own. */
function TimeOf({ told }: { told: RowVerdict }): JSX.Element | null {
  if (told.withLine !== undefined) return <span class="step-time">{t('prog.row.with', { line: told.withLine })}</span>;
  if (!told.time || told.time.most <= 0) return null;
  return <span class="step-time">{timeSpan(told.time.least, told.time.most)}</span>;
}

function Mark({ told }: { told: RowVerdict }): JSX.Element {
  const { verdict } = told;
  const text = verdict === 'unchecked' ? blindText(told) : t(`prog.row.${verdict}`);
  return (
    <span class={`step-verdict ${verdict}`} title={text}>
      {verdict === 'unchecked' ? '·' : <Icon name={verdict === 'fine' ? 'check' : 'fault'} size={14} />}
      <span class="sr-only">{text}</span>
    </span>
  );
}

/** Why nothing is said of a row. */
function blindText({ because }: RowVerdict): string {
  if (because === undefined) return t('prog.row.unchecked');
  if (because === 'text' || because === 'end') return t(`prog.row.because.${because}`);
  const { line, file } = because;
  return file ? t('prog.row.because.called', { line, file }) : t('prog.row.because', { line });
}

/** A step behind the one that is open, else behind the last one. */
function AddStep(): JSX.Element {
  const [open, setOpen] = useState(false);
  const one = model.value!;
  const add = (word: Word) => {
    const here = standing();
    if (!here) return;
    const called = Object.keys(shelf.value.programs)[0];
    const change = insertRows(
      text.peek(),
      selected.peek() ?? rowCount(text.peek()),
      newRows(word, one, here.joints, here.tool, called, store.cell.value?.baskets?.[0]?.name),
    );
    edit(change.text, change.line);
    setOpen(false);
    say('prog.added', { word, line: change.line });
  };
  return (
    <div class="add-step">
      <button type="button" class="add" aria-expanded={open} data-tour="add-step" onClick={() => setOpen(!open)}>
        <Icon name="plus" /> {selected.value ? t('prog.add.behind', { line: selected.value }) : t('prog.add')}
      </button>
      {open && (
        <div class="add-words" role="group" aria-label={t('prog.add')}>
          {wordsOf(one).map((word) => (
            <button type="button" key={word} title={tWord('prog.what', word)} onClick={() => add(word)}>
              <Icon name={kIcons[word]!} size={16} />
              <span>
                {word}
                <small>{tWord('prog.what', word)}</small>
              </span>
            </button>
          ))}
        </div>
      )}
    </div>
  );
}
