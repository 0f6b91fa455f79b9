// Which scene, whose camera, and with what token.

import type { Scene } from '@treeline/client';

import { whySceneCannotAnswer } from '../model/words.js';
import { button, card, el, setShown, setText } from '../common/dom.js';

export interface SceneCardEvents {
  readonly onScene: (name: string) => void;
  readonly onStart: () => void;
  readonly onStartInSpace: () => void;
  readonly onStop: () => void;
  readonly onToken: (token: string) => void;
}

export class SceneCard {
  readonly element: HTMLElement;
  private readonly select = el('select', { id: 'scene', on: {
    change: () => this.events.onScene(this.select.value) } });
  private readonly start: HTMLButtonElement;
  private readonly startInSpace: HTMLButtonElement;
  private readonly token = el('input', { id: 'token', attributes: {
    'type': 'password', 'autocomplete': 'off', 'spellcheck': 'false' } });
  private readonly access: HTMLDetailsElement;
  private isRunning = false;

  constructor(private readonly events: SceneCardEvents, token: string) {
    this.token.value = token;
    this.token.addEventListener('keydown', (event) => {
      if (event.key === 'Enter') events.onToken(this.token.value.trim());
    });
    this.start = button('Start camera',
        () => (this.isRunning ? events.onStop() : events.onStart()),
        { id: 'start', class: 'primary' });
    this.startInSpace = button('Start in the space around you',
        () => events.onStartInSpace(), { id: 'start-space' });
    setShown(this.startInSpace, false);
    this.access = el('details', { id: 'access' }, el('summary', {}, 'Access'),
        el('label', { attributes: { for: 'token' } }, 'Token of the server'),
        el('div', { class: 'row' }, this.token, button('Use',
            () => events.onToken(this.token.value.trim()),
            { id: 'use-token' })),
        el('p', { class: 'detail' }, 'Needed where the server asks for one. ' +
          'It is kept until this window closes.'));
    this.element = card('Scene', 'scene-card',
        el('label', { class: 'hidden-label', attributes: { for: 'scene' } },
            'Scene'),
        el('div', { class: 'row' }, this.select, this.start), this.startInSpace,
        this.access);
    this.setScenes([], '');
  }

  get scene(): string {
    return this.select.value;
  }

  setScenes(scenes: readonly Scene[], chosen: string): void {
    this.select.replaceChildren(...scenes.map((scene) => {
      const why = whySceneCannotAnswer(scene);
      const option = el('option', { attributes: { value: scene.name } },
          (scene.displayName || scene.name) + (why === null ? '' : ` (${why})`));
      option.disabled = why !== null;
      option.selected = scene.name === chosen;
      return option;
    }));
    if (scenes.length === 0) {
      this.select.append(
          el('option', { attributes: { value: '' } }, 'No scene'));
    }
    this.setRunning(this.isRunning);
  }

  setRunning(isRunning: boolean): void {
    this.isRunning = isRunning;
    this.start.disabled = !isRunning && this.select.value === '';
    this.startInSpace.disabled = isRunning || this.select.value === '';
    setText(this.start, isRunning ? 'Stop' : 'Start camera');
  }

  /** The device tracks itself, and shows pages what its camera sees. */
  offerSpace(): void {
    setShown(this.startInSpace, true);
  }

  askForToken(): void {
    this.access.open = true;
    this.token.focus();
  }
}
