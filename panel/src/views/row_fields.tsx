import type { JSX } from 'preact';
import { useState } from 'preact/hooks';
import { t, tWord } from '../i18n';
import { atWork, canMove, knowsPlace, model, standing, store } from '../app';
import { copyRow, linesOf, removeRow, replaceLine, stepRow, type Row } from '../logic/rows';
import { fieldsOf, hereRow, readField, writeField, type Complaint, type Field } from '../logic/row_kinds';
import { written } from '../logic/quantities';
import { edit, run, selected, shelf, text, verdicts } from '../teach';
import { Icon } from './parts';
import { IconButton } from './points_list';

/** Everything that a row can say, to be filled in; and what can be done with the row. */
export function RowFields({ row, last }: { row: Row; last: number }): JSX.Element {
  const one = model.value!;
  const fields = fieldsOf(row.word, one);
  const used = (field: Field) => readField(row.tokens, field) !== '';
  const [more, setMore] = useState(false);
  const hidden = fields.filter((field) => field.extra && !used(field));
  const shown = fields.filter((field) => !field.extra || used(field) || more);
  const shift = (way: -1 | 1) => {
    const change = stepRow(text.peek(), row.line, way);
    if (change) edit(change.text, change.line);
  };
  return (
    <div class="row-fields">
      {shown.length > 0 && (
        <div class="fields">
          {shown.map((field) => (
            <RowField key={field.id} row={row} field={field} />
          ))}
        </div>
      )}
      {hidden.length > 0 && !more && (
        <button type="button" class="quiet more" onClick={() => setMore(true)}>
          {t('prog.more')}
        </button>
      )}
      <div class="row-do">
        {(row.word === 'joint' || row.word === 'move' || row.word === 'line') && (
          <button type="button" disabled={!knowsPlace.value} onClick={() => here(row)}>
            <Icon name="pin" size={16} /> {t('prog.here')}
          </button>
        )}
        <button
          type="button"
          disabled={!canMove.value || atWork.value || row.depth > 0 || row.word === 'end' || row.word === 'else' || refusedRow(row)}
          title={row.depth > 0 ? t('prog.run_from.block') : undefined}
          onClick={() => void run({ fromLine: row.line })}
          data-tour="run-from"
        >
          <Icon name="play" size={16} /> {t('prog.run_from')}
        </button>
        <span class="row tight">
          <IconButton icon="up" label={t('prog.up')} onClick={() => shift(-1)} />
          <IconButton icon="down" label={t('prog.down')} onClick={() => shift(1)} />
          {row.word !== 'end' && row.word !== 'else' && (
            <>
              <IconButton
                icon="copy"
                label={t('prog.copy')}
                onClick={() => {
                  const change = copyRow(text.peek(), row.line);
                  edit(change.text, change.line);
                }}
              />
              <IconButton
                icon="trash"
                label={last > row.line ? t('prog.remove_block', { last }) : t('prog.remove_row')}
                onClick={() => {
                  edit(removeRow(text.peek(), row.line), null);
                  selected.value = null;
                }}
              />
            </>
          )}
        </span>
      </div>
    </div>
  );
}

/** From here on nothing would run. */
const refusedRow = (row: Row): boolean => verdicts.value[row.line]?.verdict === 'refused';

/** The row goes to where the arm is now: its joints, or its tool's place. */
function here(row: Row): void {
  const one = model.peek()!;
  const stands = standing();
  if (!stands || !knowsPlace.peek()) return;
  const raw = linesOf(text.peek())[row.line - 1]!;
  edit(replaceLine(text.peek(), row.line, hereRow(raw, one, stands.joints, stands.tool)), row.line);
}

function RowField({ row, field }: { row: Row; field: Field }): JSX.Element {
  const [draft, setDraft] = useState<string | null>(null);
  const [wrong, setWrong] = useState<{ wrong: Complaint; limit?: number } | null>(null);
  const value = readField(row.tokens, field);
  const label = field.name ?? tWord('prog.field', field.id);
  const commit = (wish: string) => {
    const result = writeField(linesOf(text.peek())[row.line - 1]!, field, wish);
    if ('wrong' in result) {
      setWrong(result);
      return;
    }
    setWrong(null);
    setDraft(null);
    edit(replaceLine(text.peek(), row.line, result.raw), row.line);
  };
  const choices = choicesOf(field);
  const wide = field.kind === 'words' || field.kind === 'place' || field.kind === 'text';
  return (
    <label class={`row-field${wide ? ' wide' : ''}`}>
      <span>{label}</span>
      {choices ? (
        <select value={value} onChange={(event) => commit(event.currentTarget.value)}>
          {(!field.needed || value === '') && <option value="">–</option>}
          {value !== '' && !choices.includes(value) && <option value={value}>{value}</option>}
          {choices.map((one) => (
            <option key={one} value={one}>
              {one}
            </option>
          ))}
        </select>
      ) : (
        <input
          type="text"
          class={wrong ? 'wrong' : ''}
          value={draft ?? value}
          placeholder={field.needed ? '' : '–'}
          aria-invalid={wrong !== null}
          onInput={(event) => setDraft(event.currentTarget.value)}
          onBlur={() => draft !== null && commit(draft)}
          onKeyDown={(event) => {
            if (event.key === 'Enter' && draft !== null) commit(draft);
          }}
        />
      )}
      {wrong && (
        <em class="wrong-words" role="alert">
          {t(`prog.wrong.${wrong.wrong}`, { limit: limitText(field, wrong.limit), unit: unitHint(field) })}
        </em>
      )}
    </label>
  );
}

function choicesOf(field: Field): readonly string[] | null {
  if (field.kind === 'choice') return field.choices!;
  if (field.kind === 'point') return shelf.value.points.map((point) => point.name);
  if (field.kind === 'into') return [...(store.cell.value?.baskets ?? []), ...shelf.value.points].map((one) => one.name);
  if (field.kind === 'camera') return (store.cell.value?.cameras ?? []).filter((one) => one.lens).map((one) => one.name);
  if (field.kind === 'program') return Object.keys(shelf.value.programs);
  return null;
}

const kHints: Partial<Record<Field['kind'], string>> = {
  angle: '30deg',
  length: '20mm',
  time: '1.5s',
  share: '50%',
  speed: '80mm/s',
  accel: '500mm/s2',
  blend: '20mm',
  place: '200mm,0mm,150mm',
  count: '3',
};
const unitHint = (field: Field): string => kHints[field.kind] ?? '';

function limitText(field: Field, limit: number | undefined): string {
  if (limit === undefined) return '';
  if (field.kind === 'angle' || field.kind === 'length') return written(limit, field.kind, 1);
  return field.kind === 'share' ? `${Math.round(100 * limit)}%` : String(limit);
}
