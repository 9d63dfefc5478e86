/**
 * Esc anywhere and Space outside of text fields stop everything. They are taken before any button
 * sees them, so a button that has the focus is pressed with Enter. Where Space belongs to assistive
 * technology, both can be switched off; the button on the screen remains.
 */

export type StopKey = 'Escape' | 'Space';

const kTextTypes = new Set(['text', 'search', 'email', 'number', 'password', 'tel', 'url']);

interface FieldLike {
  tagName?: string;
  type?: string;
  isContentEditable?: boolean;
}

export function isTextField(target: unknown): boolean {
  const field = target as FieldLike | null;
  if (!field || typeof field.tagName !== 'string') return false;
  if (field.isContentEditable) return true;
  const tag = field.tagName.toUpperCase();
  return tag === 'TEXTAREA' || (tag === 'INPUT' && kTextTypes.has(field.type ?? 'text'));
}

export function stopKeyOf(event: { key: string; code: string; target: unknown }): StopKey | null {
  if (event.key === 'Escape') return 'Escape';
  const space = event.code === 'Space' || event.key === ' ';
  return space && !isTextField(event.target) ? 'Space' : null;
}

/** @return takes it back */
export function installStopKeys(
  view: EventTarget,
  options: { enabled: () => boolean; stop: (key: StopKey) => void },
): () => void {
  const down = (raw: Event) => {
    const event = raw as KeyboardEvent;
    const key = options.enabled() ? stopKeyOf(event) : null;
    if (!key) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    if (!event.repeat) options.stop(key);
  };
  // A button is pressed when Space comes up.
  const up = (raw: Event) => {
    const event = raw as KeyboardEvent;
    if (!options.enabled() || stopKeyOf(event) !== 'Space') return;
    event.preventDefault();
    event.stopImmediatePropagation();
  };
  view.addEventListener('keydown', down, { capture: true });
  view.addEventListener('keyup', up, { capture: true });
  return () => {
    view.removeEventListener('keydown', down, { capture: true });
    view.removeEventListener('keyup', up, { capture: true });
  };
}
