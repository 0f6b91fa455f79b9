// What is drawn, and what is assumed of camera and scene.

import { MAX_FIELD_OF_VIEW_DEG, MIN_FIELD_OF_VIEW_DEG } from
  '../model/camera_guess.js';
import { isUpAxis, UP_AXES, type UpAxis } from '../model/scene_up.js';
import type { Layer } from '../view/stage.js';
import { card, el, setText } from '../common/dom.js';

export interface ViewCardEvents {
  readonly onLayer: (layer: Layer, isShown: boolean) => void;
  readonly onFieldOfView: (fieldOfViewDeg: number) => void;
  readonly onUp: (up: UpAxis) => void;
}

const LAYERS: readonly (readonly [Layer, string, boolean])[] = [
  ['grid', 'Grid on the floor, 1 m', true],
  ['box', 'Box of what was recorded', true],
  ['cloud', 'Points of the model', false],
  ['keyframes', 'Where it was recorded', false],
  ['points', 'Points that agree (discs) or not (crosses)', false],
  ['loupe', 'Loupe: which pixels agree, and by how much', false],
  ['still', 'Hold the picture that was located', false],
];

const UP_NAMES: Readonly<Record<UpAxis, string>> = {
  '+z': 'z', '-z': 'minus z', '+y': 'y', '-y': 'minus y', '+x': 'x',
  '-x': 'minus x',
};

export class ViewCard {
  readonly element: HTMLElement;
  private readonly view = el('input', { id: 'view', attributes: {
    type: 'number', inputmode: 'decimal', step: '0.1',
    min: String(MIN_FIELD_OF_VIEW_DEG), max: String(MAX_FIELD_OF_VIEW_DEG),
  } });
  private readonly up = el('select', { id: 'up' });
  private readonly message = el('p', { class: 'detail', id: 'layer-message',
    attributes: { role: 'status' } });
  private readonly corrects = el('input', { id: 'corrects',
    attributes: { type: 'checkbox', checked: '' } });

  constructor(events: ViewCardEvents) {
    const layers = LAYERS.map(([layer, label, isShown]) => {
      const check = el('input', { id: `show-${layer}`,
        attributes: { type: 'checkbox' },
        on: { change: () => events.onLayer(layer, check.checked) } });
      check.checked = isShown;
      return el('label', { class: 'check' }, check, label);
    });
    this.view.addEventListener('change', () => {
      if (this.view.checkValidity() && this.view.value !== '') {
        events.onFieldOfView(this.view.valueAsNumber);
      } else {
        this.view.reportValidity();
      }
    });
    this.up.append(...UP_AXES.map((up) =>
      el('option', { attributes: { value: up } }, UP_NAMES[up])));
    this.up.addEventListener('change', () => {
      if (isUpAxis(this.up.value)) events.onUp(this.up.value);
    });
    this.element = card('Drawing', 'view-card', ...layers,
        this.message,
        el('details', { id: 'assumed' }, el('summary', {}, 'Camera and floor'),
            el('label', { class: 'field' }, 'Field of view, longer side (°)',
                this.view),
            el('label', { class: 'check' }, this.corrects,
                'Answers correct the field of view'),
            el('label', { class: 'field' }, 'Axis of the scene that is up',
                this.up)));
  }

  /** Whether answers may change the field of view. */
  get isCorrected(): boolean {
    return this.corrects.checked;
  }

  say(text: string): void {
    setText(this.message, text);
  }

  setFieldOfView(fieldOfViewDeg: number): void {
    // Not while someone types.
    if (document.activeElement === this.view) return;
    this.view.value = fieldOfViewDeg.toFixed(1);
  }

  setUp(up: UpAxis): void {
    this.up.value = up;
  }
}
