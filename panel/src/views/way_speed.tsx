import type { JSX } from 'preact';
import { t } from '../i18n';
import { way } from '../app';
import type { RobotModel } from '../logic/types';
import { Slider } from './parts';

/** How quick the way to a target is, where the robot hears of it. */
export function WaySpeed({ model, onInput }: { model: RobotModel; onInput: (speed: number) => void }): JSX.Element | null {
  if (!model.takes_speed) return null;
  return (
    <Slider
      label={t('move.speed')}
      value={way.value.speed}
      min={0.05}
      max={1}
      step={0.05}
      text={`${Math.round(100 * way.value.speed)} %`}
      onInput={onInput}
    />
  );
}
