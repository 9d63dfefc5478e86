import type { JSX } from 'preact';
import { useSignal } from '@preact/signals';
import { t } from '../i18n';
import { atWork, canMove, status, store } from '../app';
import type { RobotModel } from '../logic/types';
import { shown } from '../logic/units';
import { toolsOf, type Tool } from '../logic/tools';
import { NumberField } from './parts';

/** Jaws, gripper, suction and nozzle at hand: each press runs one row of a program. */
export function ToolKeys({ model, name }: { model: RobotModel; name: string }): JSX.Element | null {
  const refused = useSignal('');
  const sent = useSignal<Record<string, string>>({});
  const tools = toolsOf(model);
  if (tools.length === 0) return null;
  const barred = !canMove.value || atWork.value;
  const press = async (tool: Tool, argument: string) => {
    refused.value = '';
    const why = await store.runRow(name, tool.row(argument), t(`tool.${tool.word}`));
    if (why === null) sent.value = { ...sent.value, [`${name} ${tool.word}`]: argument };
    else refused.value = why;
  };
  return (
    <fieldset class="tool-keys">
      <legend>{t('tool.title')}</legend>
      {tools.map((tool) => {
        const last = sent.value[`${name} ${tool.word}`];
        const measured = tool.measured?.(status.value?.health ?? {});
        const amount = tool.amount;
        return (
          <div class="tool-row" key={tool.word}>
            <span class="joint-name">{t(`tool.${tool.word}`)}</span>
            <span class="row">
              {tool.choices.map((choice) => (
                <button
                  type="button"
                  key={choice.id}
                  disabled={barred}
                  aria-pressed={last === choice.argument}
                  onClick={() => void press(tool, choice.argument)}
                >
                  {t(`tool.${choice.id}`)}
                </button>
              ))}
            </span>
            {amount && (
              <NumberField
                label={t(`tool.${tool.word}`)}
                value={measured ?? amount.of(last) ?? amount.initial}
                measure={amount.measure}
                disabled={barred}
                onCommit={(value) => void press(tool, amount.text(value))}
              />
            )}
            {measured !== undefined && <span class="hint">{t('tool.measured', { value: shown(measured, 'length') })}</span>}
          </div>
        );
      })}
      {refused.value && (
        <p class="setup-refused" role="alert">
          {refused.value}
        </p>
      )}
    </fieldset>
  );
}
