// What this browser remembers of cameras and scenes.

import { DEFAULT_FIELD_OF_VIEW_DEG, MAX_FIELD_OF_VIEW_DEG,
  MIN_FIELD_OF_VIEW_DEG } from './camera_guess.js';
import type { Storage } from './notes.js';
import { DEFAULT_UP, isUpAxis, type UpAxis } from './scene_up.js';

const PREFIX = 'treeline.ar';
const TOKEN = `${PREFIX}.token`;

/** `local` outlasts the window, `session` does not: tokens are kept there. */
export class Settings {
  constructor(private readonly local: Storage,
      private readonly session: Storage) {}

  fieldOfViewDeg(camera: string): number {
    const stored = Number(this.local.getItem(`${PREFIX}.view.${camera}`) ?? '');
    return stored >= MIN_FIELD_OF_VIEW_DEG && stored <= MAX_FIELD_OF_VIEW_DEG ?
      stored : DEFAULT_FIELD_OF_VIEW_DEG;
  }

  keepFieldOfView(camera: string, fieldOfViewDeg: number): void {
    keep(this.local, `${PREFIX}.view.${camera}`, String(fieldOfViewDeg));
  }

  up(scene: string): UpAxis {
    const stored = this.local.getItem(`${PREFIX}.up.${scene}`) ?? '';
    return isUpAxis(stored) ? stored : DEFAULT_UP;
  }

  keepUp(scene: string, up: UpAxis): void {
    keep(this.local, `${PREFIX}.up.${scene}`, up);
  }

  get token(): string {
    return this.session.getItem(TOKEN) ?? '';
  }

  keepToken(token: string): void {
    keep(this.session, TOKEN, token);
  }
}

// A browser that keeps nothing loses what it was told, and no more.
function keep(storage: Storage, key: string, value: string): void {
  try {
    storage.setItem(key, value);
  } catch {
    // Full, or forbidden.
  }
}
