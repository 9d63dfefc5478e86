import type { JSX } from 'preact';
import { useState } from 'preact/hooks';
import { t } from '../i18n';
import { kProgramName } from '../logic/shelf';
import { changed, examples, here, history, name, openExample, openKept, openProgram, removeProgram, saveAs, shelf, text, undo } from '../teach';
import { FileButtons } from './file_buttons';
import { IconButton, Sure } from './points_list';
import { Icon, Segments } from './parts';
import { ProgramText } from './program_text';
import { RunBar } from './run_bar';
import { Timeline } from './timeline';

/** One text in two forms: rows that can be dragged and filled in, and the text itself. */
export function ProgramEditor(): JSX.Element {
  const [form, setForm] = useState<'rows' | 'text'>('rows');
  return (
    <>
      <ProgramHead />
      <div class="form-choice">
        <Segments
          hideLabel
          label={t('prog.form')}
          value={form}
          options={(['rows', 'text'] as const).map((value) => ({ value, text: t(`prog.form.${value}`) }))}
          onChange={setForm}
        />
      </div>
      <div class="editor" data-form={form}>
        <Timeline />
        <ProgramText />
      </div>
      <RunBar />
    </>
  );
}

function ProgramHead(): JSX.Element {
  const [wish, setWish] = useState<string | null>(null);
  const [sure, setSure] = useState<string | null>(null);
  const title = wish ?? name.value;
  const fits = kProgramName.test(title);
  const { programs } = shelf.value;
  const mine = Object.keys(here.value.programs);
  const saved = Object.keys(programs).sort();
  const save = () => {
    if (!fits) return;
    void saveAs(title);
    setWish(null);
  };
  const open = (value: string) => {
    const [where, what] = [value.slice(0, 1), value.slice(2)];
    setWish(null);
    if (where === 'k') openKept(what);
    else if (where === 'e') openExample(what);
    else if (where === 'n') openProgram('', '');
  };
  return (
    <div class="program-head">
      <label class="text-field">
        <span class="field-label">{t('prog.open')}</span>
        <select
          class="open"
          value=""
          onChange={(event) => {
            open(event.currentTarget.value);
            event.currentTarget.value = '';
          }}
        >
          <option value="" disabled>
            {t('prog.open.choose')}
          </option>
          <option value="n:">{t('prog.new')}</option>
          {saved.length > 0 && (
            <optgroup label={t('prog.kept')}>
              {saved.map((one) => (
                <option key={one} value={`k:${one}`}>
                  {mine.includes(one) ? t('kept.mark', { name: one }) : one}
                </option>
              ))}
            </optgroup>
          )}
          {examples.value.length > 0 && (
            <optgroup label={t('prog.examples')}>
              {examples.value.map((one) => (
                <option key={one.path} value={`e:${one.path}`}>
                  {one.name}
                </option>
              ))}
            </optgroup>
          )}
        </select>
      </label>
      <label class="text-field">
        <span class="field-label">
          {t('prog.name')}
          {changed.value && <em class="unsaved"> {t('prog.unsaved')}</em>}
        </span>
        <input
          type="text"
          value={title}
          maxLength={40}
          placeholder={t('prog.name.none')}
          aria-invalid={title !== '' && !fits}
          title={t('pts.name.rule')}
          onInput={(event) => setWish(event.currentTarget.value)}
          onKeyDown={(event) => {
            if (event.key === 'Enter') save();
          }}
        />
      </label>
      <button type="button" class="save" disabled={!fits || (!changed.value && title === name.value)} onClick={save}>
        <Icon name="check" /> <span>{t('prog.save')}</span>
      </button>
      <span class="row tight">
        <IconButton icon="undo" label={t('prog.undo')} disabled={history.value.length === 0} onClick={undo} />
        <FileButtons kind="program" />
        <IconButton
          icon="trash"
          label={t('prog.remove', { name: name.value })}
          disabled={!(name.value in programs)}
          onClick={() => setSure(name.value)}
        />
      </span>
      {sure === name.value && (
        <Sure
          text={t('prog.remove', { name: name.value })}
          onYes={() => removeProgram(name.value)}
          onEnd={() => setSure(null)}
        />
      )}
      {text.value !== '' && title !== '' && !fits && <p class="wrong-words">{t('pts.name.rule')}</p>}
    </div>
  );
}
