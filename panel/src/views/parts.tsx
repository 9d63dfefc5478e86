/** Small parts that several views are made of. */
import type { ComponentChildren, JSX } from 'preact';
import { useEffect, useRef, useState } from 'preact/hooks';
import { parseQuantity, shown, unitOf, type Measure } from '../logic/units';

const kIcons = {
  stop: 'M8 2h8l6 6v8l-6 6H8l-6-6V8z',
  jog: 'M12 2v20M2 12h20M12 2l-3 3m3-3 3 3M12 22l-3-3m3 3 3-3M2 12l3-3m-3 3 3 3M22 12l-3-3m3 3-3 3',
  move: 'M4 19c4 0 4-6 8-6s4-8 8-8M16 3l4 2-2 4',
  events: 'M5 6h14M5 12h14M5 18h9',
  fault: 'M12 3 2 20h20L12 3zM12 10v4M12 17v.5',
  check: 'M4 12l5 5L20 6',
  play: 'M7 4l13 8-13 8z',
  pause: 'M7 4v16M17 4v16',
  sun: 'M12 8a4 4 0 1 0 0 8 4 4 0 0 0 0-8zM12 2v2M12 20v2M2 12h2M20 12h2M5 5l1.5 1.5M17.5 17.5 19 19M5 19l1.5-1.5M17.5 6.5 19 5',
  moon: 'M20 14.5A8.5 8.5 0 0 1 9.5 4a8.5 8.5 0 1 0 10.5 10.5z',
  keyboard: 'M3 6h18v12H3zM7 10h.01M11 10h.01M15 10h.01M7 14h10',
  gamepad: 'M7 8h10a5 5 0 0 1 0 9c-2 0-2-2-5-2s-3 2-5 2a5 5 0 0 1 0-9zM8 11v3M6.5 12.5h3M16 12h.01',
  close: 'M6 6l12 12M18 6 6 18',
  home: 'M4 11l8-7 8 7v9h-5v-6H9v6H4z',
  reset: 'M4 12a8 8 0 1 0 2.5-5.8M4 4v4h4',
  programs: 'M4 6h2M9 6h11M4 12h2M9 12h8M4 18h2M9 18h10',
  help: 'M9 9a3 3 0 1 1 4.5 2.6c-1 .6-1.5 1.2-1.5 2.4M12 17.5v.5M12 2.5a9.5 9.5 0 1 0 0 19 9.5 9.5 0 0 0 0-19z',
  plus: 'M12 5v14M5 12h14',
  up: 'M6 15l6-6 6 6',
  down: 'M6 9l6 6 6-6',
  copy: 'M9 9h11v11H9zM15 9V4H4v11h5',
  trash: 'M4 7h16M9 7V4h6v3M6 7l1 13h10l1-13M10 11v5M14 11v5',
  undo: 'M4 10h10a5 5 0 0 1 0 10h-4M4 10l4-4M4 10l4 4',
  save: 'M12 4v11M12 15l-4-4M12 15l4-4M4 19h16',
  folder: 'M12 15V4M12 4 8 8M12 4l4 4M4 19h16',
  grip: 'M9 6h.01M15 6h.01M9 12h.01M15 12h.01M9 18h.01M15 18h.01',
  step: 'M5 5l9 7-9 7zM18 5v14',
  back: 'M19 5l-9 7 9 7zM6 5v14',
  pin: 'M12 21c-4-5-6-8-6-11a6 6 0 0 1 12 0c0 3-2 6-6 11zM12 8a2 2 0 1 0 0 4 2 2 0 0 0 0-4z',
  pen: 'M5 19l1-4L16 5l3 3L9 18z',
  line: 'M4 20 20 4M4 20h.01M20 4h.01',
  arc: 'M4 18A14 14 0 0 1 20 6',
  spline: 'M3 17c4 0 4-10 9-10s5 10 9 6',
  joint: 'M5 20V12l8-6 6 4M5 12h.01M13 6h.01',
  grab: 'M8 3v6l-3 5v4M16 3v6l3 5v4M8 9h8',
  eye: 'M2 12s4-6 10-6 10 6 10 6-4 6-10 6S2 12 2 12zM12 9a3 3 0 1 0 0 6 3 3 0 0 0 0-6z',
  wait: 'M12 3a9 9 0 1 0 0 18 9 9 0 0 0 0-18zM12 7v5l3 3',
  loop: 'M4 12a7 7 0 0 1 12-5l3 3M19 5v5h-5M20 12a7 7 0 0 1-12 5l-3-3M5 19v-5h5',
  branch: 'M6 4v16M6 14c8 0 10-3 10-8M13 8l3-3 3 3',
  call: 'M5 4h10l4 4v12H5zM9 12h6M9 16h6',
  setup: 'M10 6h11M10 12h11M10 18h11M3 6l1.5 1.5L7 5M3 12l1.5 1.5L7 11M3 18l1.5 1.5L7 17',
  plots: 'M3 3v18h18M6 15l4-5 4 3 6-8',
  device: 'M7 7h10v10H7zM10 3v4M14 3v4M10 17v4M14 17v4M3 10h4M3 14h4M17 10h4M17 14h4',
  later: 'M5 12h14M13 6l6 6-6 6',
  minus: 'M5 12h14',
  skip: 'M6 5l8 7-8 7zM18 5v14',
  fit: 'M4 9V4h5M20 9V4h-5M4 15v5h5M20 15v5h-5',
} as const;
export type IconName = keyof typeof kIcons;

export function Icon({ name, size = 18 }: { name: IconName; size?: number }): JSX.Element {
  return (
    <svg class="icon" width={size} height={size} viewBox="0 0 24 24" aria-hidden="true" focusable="false">
      <path d={kIcons[name]} />
    </svg>
  );
}

/** One of several: a radio group that looks like one bar. */
export function Segments<Value extends string>(props: {
  label: string;
  value: Value;
  options: readonly { value: Value; text: string }[];
  onChange: (value: Value) => void;
  hideLabel?: boolean;
}): JSX.Element {
  const { options, value } = props;
  const onKey = (event: KeyboardEvent) => {
    const step = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
    if (!step) return;
    event.preventDefault();
    event.stopPropagation();
    const at = options.findIndex((one) => one.value === value);
    const next = options[(at + step + options.length) % options.length]!;
    props.onChange(next.value);
    const group = event.currentTarget as HTMLElement;
    (group.querySelectorAll('button')[options.indexOf(next)] as HTMLElement | undefined)?.focus();
  };
  return (
    <div class="field">
      <span class={props.hideLabel ? 'sr-only' : 'field-label'}>{props.label}</span>
      <div class="segments" role="radiogroup" aria-label={props.label} onKeyDown={onKey}>
        {options.map((one) => (
          <button
            type="button"
            role="radio"
            key={one.value}
            aria-checked={one.value === value}
            tabIndex={one.value === value ? 0 : -1}
            onClick={() => props.onChange(one.value)}
          >
            {one.text}
          </button>
        ))}
      </div>
    </div>
  );
}

/** A button that stays pressed. */
export function Toggle(props: {
  pressed: boolean;
  onChange: (pressed: boolean) => void;
  children: ComponentChildren;
  title?: string;
}): JSX.Element {
  return (
    <button
      type="button"
      class="toggle"
      aria-pressed={props.pressed}
      title={props.title}
      onClick={() => props.onChange(!props.pressed)}
    >
      {props.children}
    </button>
  );
}

/** A slider with its value behind it. */
export function Slider(props: {
  label: string;
  value: number;
  min: number;
  max: number;
  step: number;
  text: string;
  onInput: (value: number) => void;
}): JSX.Element {
  const share = ((props.value - props.min) / (props.max - props.min)) * 100;
  return (
    <label class="slider-field">
      <span class="field-label">{props.label}</span>
      <input
        type="range"
        class="slider"
        min={props.min}
        max={props.max}
        step={props.step}
        value={props.value}
        style={{ '--share': `${share}%` } as JSX.CSSProperties}
        aria-valuetext={props.text}
        onInput={(event) => props.onInput(Number(event.currentTarget.value))}
      />
      <output class="slider-text">{props.text}</output>
    </label>
  );
}

/** A number that people type in any unit. It counts when they leave it or press Enter. */
export function NumberField(props: {
  label: string;
  value: number;
  measure: Measure;
  onCommit: (value: number) => void;
  disabled?: boolean;
  readOnly?: boolean;
}): JSX.Element {
  const [draft, setDraft] = useState<string | null>(null);
  const [wrong, setWrong] = useState(false);
  const input = useRef<HTMLInputElement>(null);
  const text = draft ?? shown(props.value, props.measure);
  const commit = () => {
    if (draft === null) return;
    const value = parseQuantity(draft, props.measure);
    setWrong(value === null);
    if (value === null) return;
    setDraft(null);
    props.onCommit(value);
  };
  return (
    <span class={`number${wrong ? ' wrong' : ''}`}>
      <input
        ref={input}
        type="text"
        inputMode="decimal"
        aria-label={props.label}
        aria-invalid={wrong}
        value={text}
        disabled={props.disabled}
        readOnly={props.readOnly}
        onFocus={(event) => event.currentTarget.select()}
        onInput={(event) => setDraft(event.currentTarget.value)}
        onBlur={() => {
          commit();
          setDraft(null);
          setWrong(false);
        }}
        onKeyDown={(event) => {
          if (event.key === 'Enter') commit();
        }}
      />
      <span class="unit" aria-hidden="true">
        {unitOf(props.measure)}
      </span>
    </span>
  );
}

/** Calls back every `ms` while it is shown and `on`, drawn or not. */
export function useTimer(on: boolean, ms: number, callback: () => void): void {
  const latest = useRef(callback);
  latest.current = callback;
  useEffect(() => {
    if (!on) return;
    const timer = setInterval(() => latest.current(), ms);
    return () => clearInterval(timer);
  }, [on, ms]);
}

/** Calls back on every frame while it is shown and `on`. */
export function useFrames(on: boolean, callback: (seconds: number) => void): void {
  const latest = useRef(callback);
  latest.current = callback;
  useEffect(() => {
    if (!on) return;
    let last = performance.now();
    let frame = requestAnimationFrame(function turn(now) {
      // Before the call, which may throw.
      frame = requestAnimationFrame(turn);
      const seconds = (now - last) / 1000;
      last = now;
      latest.current(seconds);
    });
    return () => cancelAnimationFrame(frame);
  }, [on]);
}
