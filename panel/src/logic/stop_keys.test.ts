import { describe, expect, it } from 'vitest';
import { installStopKeys, stopKeyOf, type StopKey } from './stop_keys';

const button = { tagName: 'BUTTON' };
const text = { tagName: 'INPUT', type: 'text' };
const slider = { tagName: 'INPUT', type: 'range' };

class Key extends Event {
  constructor(
    type: string,
    readonly key: string,
    readonly code: string,
    readonly repeat = false,
  ) {
    super(type, { cancelable: true });
  }
}

describe('stop keys', () => {
  it('are Esc anywhere and Space where nobody types', () => {
    expect(stopKeyOf({ key: 'Escape', code: 'Escape', target: text })).toBe('Escape');
    expect(stopKeyOf({ key: ' ', code: 'Space', target: text })).toBeNull();
    expect(stopKeyOf({ key: ' ', code: 'Space', target: button })).toBe('Space');
    expect(stopKeyOf({ key: ' ', code: 'Space', target: slider })).toBe('Space');
    expect(stopKeyOf({ key: ' ', code: 'Space', target: { tagName: 'DIV', isContentEditable: true } })).toBeNull();
    expect(stopKeyOf({ key: 'Enter', code: 'Enter', target: button })).toBeNull();
  });

  it('are taken before anybody else hears of them, once a press', () => {
    const view = new EventTarget();
    const stops: StopKey[] = [];
    let heard = 0;
    let enabled = true;
    const off = installStopKeys(view, { enabled: () => enabled, stop: (key) => stops.push(key) });
    view.addEventListener('keydown', () => ++heard);
    view.addEventListener('keyup', () => ++heard);
    const press = new Key('keydown', ' ', 'Space');
    view.dispatchEvent(press);
    view.dispatchEvent(new Key('keydown', ' ', 'Space', true));
    view.dispatchEvent(new Key('keyup', ' ', 'Space'));
    expect(press.defaultPrevented).toBe(true);
    expect(stops).toEqual(['Space']);
    expect(heard).toBe(0);
    enabled = false;
    view.dispatchEvent(new Key('keydown', ' ', 'Space'));
    expect(stops).toHaveLength(1);
    expect(heard).toBe(1);
    enabled = true;
    off();
    view.dispatchEvent(new Key('keydown', 'Escape', 'Escape'));
    expect(stops).toHaveLength(1);
  });
});
