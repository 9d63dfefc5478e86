import type { JSX } from 'preact';
import { t } from '../i18n';
import { model } from '../app';
import { keeps, said, tab, type TeachTab } from '../teach';
import { Segments } from './parts';
import { PointsList } from './points_list';
import { ProgramEditor } from './program_editor';
import { KeptNotes } from './kept_notes';
import { ReadyFirst } from './ready_first';
import { RideForm } from './ride_form';

const kTabs: TeachTab[] = ['points', 'program', 'ride'];

/** Points that are taught, programs that are made of them, and random rides. */
export function ProgramsPane(): JSX.Element {
  if (!model.value) return <p class="empty">{t('robot.pick')}</p>;
  return (
    <div class="pane-body programs" data-tour="programs">
      <ReadyFirst />
      <Segments
        hideLabel
        label={t('view.programs')}
        value={tab.value}
        options={kTabs.map((value) => ({ value, text: t(`prog.tab.${value}`) }))}
        onChange={(value) => (tab.value = value)}
      />
      {!keeps.value && (
        <p class="callout grave" role="alert">
          {t('prog.not_kept')}
        </p>
      )}
      {tab.value !== 'ride' && <KeptNotes />}
      {tab.value === 'points' ? <PointsList /> : tab.value === 'ride' ? <RideForm /> : <ProgramEditor />}
      <p class="sr-only" aria-live="polite">
        {said.value}
      </p>
    </div>
  );
}
