import type { JSX } from 'preact';
import { useEffect, useRef, useState } from 'preact/hooks';
import { t, tWord } from '../i18n';
import { model, robot } from '../app';
import { chosen, clear, filter, frames, lost, matched, paused, sentence } from '../device_state';
import { axesText, fileText, visible, type WireFrame } from '../logic/wire';
import { handOver } from '../hand_over';
import { Icon, Segments, Toggle } from './parts';

const kRow = 24; // px, as .wire-row has it

const wayOf = (frame: WireFrame): string => t(frame.to === 'device' ? 'wire.to_device' : 'wire.to_host');

/** Everything that passes on the wire, both ways, as it passes. */
export function WireDock(): JSX.Element {
  const all = frames.value;
  const now = filter.value;
  const shown = matched.value;
  const hasFill = (robot.value && model.value?.robot === 'robot-arm-2') || all.some((one) => one.kind === 'fill');
  const save = () => {
    const stamp = new Date().toISOString().slice(0, 19);
    const head = `# ${robot.value}, ${stamp}Z, ${t('wire.lost', { count: lost.value })}`;
    handOver(`${robot.value}_wire_${stamp.replaceAll(':', '-')}.txt`, fileText(head, shown, sentence));
  };
  return (
    <section class="dock wire-dock" aria-label={t('wire.title')}>
      <div class="dock-head wire-head">
        <button
          type="button"
          class={paused.value ? 'primary' : ''}
          aria-pressed={paused.value}
          onClick={() => (paused.value = !paused.value)}
        >
          <Icon name={paused.value ? 'play' : 'pause'} size={15} /> {t(paused.value ? 'wire.go_on' : 'wire.pause')}
        </button>
        <Segments
          hideLabel
          label={t('wire.way')}
          value={now.way}
          options={(['both', 'device', 'host'] as const).map((value) => ({ value, text: t(`wire.way.${value}`) }))}
          onChange={(way) => (filter.value = { ...now, way })}
        />
        <input
          type="search"
          class="wire-words"
          aria-label={t('wire.filter')}
          placeholder={t('wire.filter')}
          value={now.words}
          onInput={(event) => (filter.value = { ...now, words: event.currentTarget.value })}
        />
        {hasFill && (
          <Toggle pressed={now.fill} title={t('wire.fill.help')} onChange={(fill) => (filter.value = { ...now, fill })}>
            {t('wire.fills')}
          </Toggle>
        )}
        <span class="row tight wire-tools">
          <button type="button" class="quiet" title={t('wire.clear')} aria-label={t('wire.clear')} onClick={clear}>
            <Icon name="trash" size={16} />
          </button>
          <button type="button" disabled={shown.length === 0} onClick={save}>
            <Icon name="save" size={16} /> {t('wire.save')}
          </button>
        </span>
      </div>
      <List shown={shown} />
      <p class="wire-foot">
        <span role="status">{t('wire.count', { shown: shown.length, all: all.length })}</span>
        {lost.value > 0 && <span class="wire-lost">{t('wire.lost', { count: lost.value })}</span>}
        {paused.value && <span>{t('wire.paused')}</span>}
      </p>
    </section>
  );
}

/** Only the rows in sight are on the page; it follows what comes while its end is in sight. */
function List({ shown }: { shown: WireFrame[] }): JSX.Element {
  const box = useRef<HTMLDivElement>(null);
  const [top, setTop] = useState(0);
  const [height, setHeight] = useState(200);
  const follows = useRef(true);
  const at = shown.findIndex((one) => one.sequence === chosen.value);
  const last = shown.at(-1)?.sequence;

  useEffect(() => {
    const watch = new ResizeObserver(() => setHeight(box.current?.clientHeight ?? 200));
    watch.observe(box.current!);
    return () => watch.disconnect();
  }, []);
  useEffect(() => {
    const now = box.current!;
    if (follows.current) now.scrollTop = now.scrollHeight;
    setTop(now.scrollTop);
  }, [last, shown.length]);

  const choose = (index: number) => {
    const one = shown[Math.min(shown.length - 1, Math.max(0, index))];
    if (!one) return;
    chosen.value = one.sequence;
    follows.current = false;
    const now = box.current!;
    const y = shown.indexOf(one) * kRow;
    if (y < now.scrollTop) now.scrollTop = y;
    if (y + kRow > now.scrollTop + now.clientHeight) now.scrollTop = y + kRow - now.clientHeight;
  };
  const onKey = (event: KeyboardEvent) => {
    const page = Math.floor(height / kRow) - 1;
    const from = at >= 0 ? at : shown.length;
    const to = {
      ArrowUp: from - 1,
      ArrowDown: at >= 0 ? from + 1 : shown.length - 1,
      PageUp: from - page,
      PageDown: from + page,
      Home: 0,
      End: shown.length - 1,
    }[event.key];
    if (to === undefined) return;
    event.preventDefault();
    event.stopPropagation();
    choose(to);
    if (event.key === 'End') follows.current = true;
  };
  const { first, end } = visible(shown.length, kRow, top, height);
  const open = at >= 0 ? shown[at]! : null;
  return (
    <div class="wire-body">
      <div
        ref={box}
        class="wire-list"
        role={shown.length > 0 ? 'listbox' : 'group'}
        tabIndex={0}
        aria-label={t('wire.list')}
        aria-activedescendant={at >= first && at < end ? `wire-${shown[at]!.sequence}` : undefined}
        onKeyDown={onKey}
        onScroll={(event) => {
          const now = event.currentTarget;
          follows.current = now.scrollTop + now.clientHeight >= now.scrollHeight - kRow;
          setTop(now.scrollTop);
        }}
      >
        <div style={{ height: `${shown.length * kRow}px`, position: 'relative' } as JSX.CSSProperties}>
          {shown.slice(first, end).map((one, i) => (
            <div
              key={one.sequence}
              id={`wire-${one.sequence}`}
              role="option"
              aria-selected={one.sequence === chosen.value}
              aria-setsize={shown.length}
              aria-posinset={first + i + 1}
              class={`wire-row to-${one.to} kind-${one.kind}`}
              style={{ transform: `translateY(${(first + i) * kRow}px)` } as JSX.CSSProperties}
              onClick={() => choose(first + i)}
            >
              <span class="wire-time">{one.at_s.toFixed(3)}</span>
              <span class="wire-way">
                <span aria-hidden="true">{one.to === 'device' ? '→' : '←'}</span> {wayOf(one)}
              </span>
              {one.axes && <span class="wire-axes">{axesText(one, ' ')}</span>}
              <code class="wire-hex">{one.hex}</code>
              <span class="wire-text">{sentence(one)}</span>
            </div>
          ))}
        </div>
        {shown.length === 0 && <p class="empty">{t(frames.value.length > 0 ? 'wire.none.filtered' : 'wire.none')}</p>}
      </div>
      {open && (
        <div class={`wire-open to-${open.to} kind-${open.kind}`} role="region" aria-label={t('wire.message')}>
          <p>
            <strong>{tWord('wire.m', open.name)}</strong>
            <span class="muted">
              {wayOf(open)} {axesText(open, ' ')}, {open.at_s.toFixed(6)} s, {t('wire.number', { number: open.sequence })}
            </span>
            <button type="button" class="quiet" aria-label={t('wire.close')} onClick={() => (chosen.value = null)}>
              <Icon name="close" size={14} />
            </button>
          </p>
          <code class="raw">{open.hex}</code>
          {open.fields.length > 0 && (
            <dl>
              {open.fields.map(([name, value]) => (
                <div key={name}>
                  <dt>{tWord('wire.field', name)}</dt>
                  <dd>{typeof value === 'string' ? tWord('wire.value', value) : value}</dd>
                </div>
              ))}
            </dl>
          )}
        </div>
      )}
    </div>
  );
}
