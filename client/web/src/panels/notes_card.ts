// The notes of the scene, and the dialog in which one is written.

import { MAX_NOTE_LENGTH, type Note } from '../model/notes.js';
import { button, card, el, setShown, setText } from '../common/dom.js';

export interface NotesCardEvents {
  /** At the cross. */
  readonly onPin: () => void;
  readonly onEdit: (note: Note) => void;
}

export class NotesCard {
  readonly element: HTMLElement;
  private readonly list = el('ul', { class: 'notes', id: 'notes' });
  private readonly empty = el('p', { class: 'detail' },
      'Tap the picture to pin a note to what is there, or move the cross ' +
      'with the arrow keys.');
  private readonly message =
      el('p', { class: 'detail', id: 'note-message',
        attributes: { role: 'status' } });

  private readonly pin: HTMLButtonElement;

  constructor(private readonly events: NotesCardEvents) {
    this.pin = button('Pin a note at the cross', events.onPin, { id: 'pin' });
    this.element = card('Notes', 'notes-card', this.empty, this.list,
        this.message, this.pin);
  }

  setNotes(notes: readonly Note[]): void {
    setShown(this.empty, notes.length === 0);
    this.list.replaceChildren(...notes.map((note) => el('li', {},
        el('span', { class: 'note-text' }, note.text),
        button('Edit', () => this.events.onEdit(note),
            { id: `edit-${note.id}`,
              attributes: { 'aria-label': `Edit the note: ${note.text}` } }))));
  }

  /** To the note's button or, where it is gone, to what pins another. */
  focus(noteId: string): void {
    (document.getElementById(`edit-${noteId}`) ?? this.pin).focus();
  }

  say(text: string): void {
    setText(this.message, text);
  }
}

export type NoteEdit = { readonly text: string } | 'deleted' | 'cancelled';

/** Asks for a note's text. */
export class NoteDialog {
  readonly element: HTMLDialogElement;
  private readonly input = el('input', { id: 'note-input', attributes: {
    maxlength: String(MAX_NOTE_LENGTH), autocomplete: 'off' } });
  private readonly remove =
      button('Delete', () => this.end('deleted'), { id: 'note-delete' });
  private resolve: (edit: NoteEdit) => void = () => {};

  constructor() {
    this.input.addEventListener('keydown', (event) => {
      if (event.key !== 'Enter') return;
      // Else the button that has the focus by then would be pressed.
      event.preventDefault();
      this.save();
    });
    this.element = el('dialog', { attributes: {
      'aria-labelledby': 'note-label' },
    on: { cancel: () => this.end('cancelled') } },
    el('label', { id: 'note-label', attributes: { for: 'note-input' } },
        'Note'),
    this.input,
    el('div', { class: 'dialog-buttons' }, this.remove,
        button('Cancel', () => this.end('cancelled')),
        button('Save', () => this.save(),
            { id: 'note-save', class: 'primary' })));
  }

  /** `text`: of a note that there is, which can be deleted; null: a new one. */
  ask(text: string | null): Promise<NoteEdit> {
    this.input.value = text ?? '';
    setShown(this.remove, text !== null);
    this.element.showModal();
    this.input.focus();
    return new Promise((resolve) => { this.resolve = resolve; });
  }

  private save(): void {
    const text = this.input.value.trim();
    this.end(text === '' ? 'cancelled' : { text });
  }

  private end(edit: NoteEdit): void {
    this.element.close();
    this.resolve(edit);
  }
}
