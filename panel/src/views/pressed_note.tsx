import type { JSX } from 'preact';
import { signal } from '@preact/signals';
import { useEffect, useLayoutEffect, useRef, useState } from 'preact/hooks';
import { store } from '../app';
import { answerTo, beside } from '../logic/pressed';
import { NoteCard } from './note';

const kControls = 'button, a[href], summary, select, input[type=checkbox], [role=button]';
const kId = 'pressed-note';

const pressed = signal<{ control: HTMLElement; at: number; lastNote: number } | null>(null);

/** The one that is shown beside what was pressed; the list of all leaves it out meanwhile. */
export function pressedNote() {
  return pressed.value?.control.isConnected ? answerTo(store.notes.value, pressed.value) : null;
}

function press(event: Event): void {
  const control = event.target instanceof Element ? event.target.closest<HTMLElement>(kControls) : null;
  // Who closes the card, or scrolls, has pressed nothing else.
  if (!control || control.closest(`#${kId}`)) return;
  pressed.value = { control, at: Date.now(), lastNote: store.notes.peek().at(-1)?.id ?? 0 };
}

function pressKey(event: KeyboardEvent): void {
  if (event.key === 'Enter' || event.key === ' ') press(event);
}

/** An action that fails says so beside the button that was pressed, wherever on the page that is. */
export function PressedNote(): JSX.Element | null {
  const card = useRef<HTMLDivElement>(null);
  const [, follow] = useState(0);
  useEffect(() => {
    const moved = () => follow((count) => count + 1);
    addEventListener('pointerdown', press, true);
    addEventListener('keydown', pressKey, true);
    addEventListener('scroll', moved, true);
    addEventListener('resize', moved);
    return () => {
      removeEventListener('pointerdown', press, true);
      removeEventListener('keydown', pressKey, true);
      removeEventListener('scroll', moved, true);
      removeEventListener('resize', moved);
    };
  }, []);
  const note = pressedNote();
  const control = pressed.value?.control;
  const shown = note !== null && control !== undefined;
  useEffect(() => {
    if (!shown) return;
    // A view that closes takes its buttons along; then the list has what they were refused with.
    const look = setInterval(() => {
      if (!control.isConnected) pressed.value = null;
    }, 200);
    return () => clearInterval(look);
  }, [shown, control]);
  useLayoutEffect(() => {
    if (!shown || !card.current) return;
    control.setAttribute('aria-describedby', kId);
    const { width, height } = card.current.getBoundingClientRect();
    const at = beside(control.getBoundingClientRect(), { width, height }, { width: innerWidth, height: innerHeight });
    card.current.style.left = `${at.left}px`;
    card.current.style.top = `${at.top}px`;
    return () => control.removeAttribute('aria-describedby');
  });
  if (!shown) return null;
  return (
    <div class="pressed-note" id={kId} role="alert" ref={card}>
      <NoteCard note={note} />
    </div>
  );
}
