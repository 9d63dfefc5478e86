import type { JSX } from 'preact';
import { refusalSentence, t } from '../i18n';
import { store } from '../app';
import type { Note } from '../logic/store';
import { Icon } from './parts';

/** One refusal, until somebody has read it. */
export function NoteCard({ note }: { note: Note }): JSX.Element {
  return (
    <div class={`note note-${note.kind}`}>
      <p>
        {note.robot && <strong>{note.robot}: </strong>}
        {note.kind === 'lost' && (note.text === 'closed' || note.text === 'timeout')
          ? t(`note.lost.${note.text}`)
          : refusalSentence({ message: note.text, data: note.data })}
      </p>
      <button type="button" class="quiet" aria-label={t('note.dismiss')} onClick={() => store.dismiss(note.id)}>
        <Icon name="close" size={14} />
      </button>
    </div>
  );
}
