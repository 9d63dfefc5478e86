import type { JSX } from 'preact';
import { useEffect, useRef } from 'preact/hooks';
import { t } from '../i18n';
import { linesOf } from '../logic/rows';
import { edit, runningLine, selected, text, verdicts } from '../teach';

/** Parts of a line: the step, values, remark. Only for the eye; what counts is the field above it. */
function Painted({ raw }: { raw: string }): JSX.Element {
  const hash = raw.indexOf('#');
  const code = hash < 0 ? raw : raw.slice(0, hash);
  const match = /^(\s*)(\S*)([\s\S]*)$/.exec(code)!;
  return (
    <>
      {match[1]}
      <b>{match[2]}</b>
      {match[3]!.split(/(=\S+|\s-?\d\S*)/).map((part, i) => (i % 2 ? <i key={i}>{part}</i> : part))}
      {hash >= 0 && <s>{raw.slice(hash)}</s>}
      {raw === '' && '\u200b'}
    </>
  );
}

/** The program's text, with each line's number and verdict beside it. */
export function ProgramText(): JSX.Element {
  const field = useRef<HTMLTextAreaElement>(null);
  const lines = linesOf(text.value);
  // The line that is open as a row is in view here, too.
  useEffect(() => {
    const line = selected.value;
    const box = field.current?.parentElement;
    if (line === null || !box || document.activeElement === field.current) return;
    box.querySelector<HTMLElement>(`pre > div:nth-child(${line})`)?.scrollIntoView({ block: 'nearest' });
  }, [selected.value]);
  const follow = () => {
    const area = field.current!;
    const line = linesOf(area.value.slice(0, area.selectionStart)).length;
    if (selected.peek() !== null) selected.value = line;
  };
  return (
    <section class="program-text" aria-label={t('prog.form.text')}>
      <div class="text-box">
        <pre aria-hidden="true">
          {lines.map((raw, i) => (
            <div
              key={i}
              data-verdict={verdicts.value[i + 1]?.verdict}
              data-running={runningLine.value === i + 1 ? 'true' : undefined}
              data-open={selected.value === i + 1 ? 'true' : undefined}
            >
              <Painted raw={raw} />
            </div>
          ))}
        </pre>
        <textarea
          ref={field}
          spellcheck={false}
          autocapitalize="off"
          autocomplete="off"
          aria-label={t('prog.text')}
          value={text.value}
          onInput={(event) => edit(event.currentTarget.value)}
          onKeyUp={follow}
          onClick={follow}
        />
      </div>
    </section>
  );
}
