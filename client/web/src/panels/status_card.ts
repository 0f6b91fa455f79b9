// What the server says of the newest picture.

import type { Located } from '../camera/locator.js';
import { accuracyOf } from '../model/accuracy.js';
import { fieldOfViewDegOf } from '../model/camera_guess.js';
import type { Saying } from '../model/words.js';
import { card, el, setData, setText } from '../common/dom.js';

const FIGURES = [
  ['confidence', 'Confidence'],
  ['accuracy', 'Accuracy (95 %)'],
  ['position', 'Position in the scene'],
  ['support', 'Points that agree'],
  ['time', 'Round trip'],
  ['focal', 'Field of view'],
] as const;

type Figure = typeof FIGURES[number][0];

const NOTHING = '–';

// Never more than there is: 99.97 % is not 100 %.
const percent = (share: number) =>
  `${(Math.floor(1000 * share) / 10).toFixed(1)} %`;

export class StatusCard {
  readonly element: HTMLElement;
  private readonly title = el('p', { class: 'status-title', id: 'state' });
  private readonly text = el('p', { class: 'status-text', id: 'state-text' });
  private readonly values = new Map<Figure, HTMLElement>();

  constructor() {
    const rows = FIGURES.map(([key, label]) => {
      const value = el('dd', { id: key }, NOTHING);
      this.values.set(key, value);
      return el('div', {}, el('dt', {}, label), value);
    });
    this.element = card('Where the camera is', 'status',
        el('div', { class: 'space-part', attributes: { role: 'status' } },
            this.title, this.text),
        el('dl', { class: 'figures' }, ...rows));
  }

  say({ title, text, tone }: Saying): void {
    setText(this.title, title);
    setText(this.text, text);
    setData(this.element, 'tone', tone);
  }

  clear(): void {
    for (const value of this.values.values()) setText(value, NOTHING);
  }

  showFigures(located: Located): void {
    if (!('answer' in located)) {
      this.clear();
      return;
    }
    const { answer, stated } = located;
    this.set('confidence', percent(answer.confidence));
    this.set('support', `${answer.inliers} of ${answer.samples}`);
    this.set('time', `${answer.roundTripMs.toFixed(0)} ms, ` +
        `${answer.timings.totalMs.toFixed(0)} of it in the server`);
    if (!answer.localized) {
      this.set('position', NOTHING);
      this.set('accuracy', NOTHING);
      this.set('focal', NOTHING);
      return;
    }
    const { x, y, z } = answer.worldFromCamera.translationM;
    this.set('position',
        [x, y, z].map((metres) => metres.toFixed(2)).join(', ') + ' m');
    const { positionM, rotationDeg } = accuracyOf(answer.covariance);
    this.set('accuracy',
        `${(100 * positionM).toFixed(1)} cm, ${rotationDeg.toFixed(1)}°`);
    const viewDeg = fieldOfViewDegOf(stated.fxPx * answer.focalScale,
        stated.widthPx, stated.heightPx);
    this.set('focal', `${viewDeg.toFixed(1)}°` + (answer.focalScale === 1 ?
      ', as stated' : `, focal length × ${answer.focalScale.toFixed(3)}`));
  }

  private set(figure: Figure, text: string): void {
    setText(this.values.get(figure)!, text);
  }
}
