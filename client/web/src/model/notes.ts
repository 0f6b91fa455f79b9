// Notes in a scene, kept in this browser.

import type { Vector3 } from '@treeline/client';

export interface Note {
  readonly id: string;
  readonly text: string;
  readonly pointInWorldM: Vector3;
}

/** localStorage, or what is like it. */
export type Storage = Pick<globalThis.Storage, 'getItem' | 'setItem'>;

export const MAX_NOTE_LENGTH = 200;

const keyOf = (scene: string) => `treeline.ar.notes.${scene}`;

const isNote = (value: unknown): value is Note => {
  const note = value as Partial<Note> | null;
  const p = note?.pointInWorldM;
  return typeof note?.id === 'string' && typeof note.text === 'string' &&
      [p?.x, p?.y, p?.z].every(Number.isFinite);
};

/** Of one scene; what is stored and is no note is left out. */
export function loadNotes(storage: Storage, scene: string): Note[] {
  try {
    const stored: unknown = JSON.parse(storage.getItem(keyOf(scene)) ?? '[]');
    return Array.isArray(stored) ? stored.filter(isNote) : [];
  } catch {
    return [];
  }
}

/** False: the browser keeps nothing, as in some private windows. */
export function saveNotes(
    storage: Storage, scene: string, notes: readonly Note[]): boolean {
  try {
    storage.setItem(keyOf(scene), JSON.stringify(notes));
    return true;
  } catch {
    return false;
  }
}
