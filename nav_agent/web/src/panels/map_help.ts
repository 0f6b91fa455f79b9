// What the map's colours mean, how to move it, and which keys do what.

import { heightColour, heightShare } from '../model/colours.js';
import { scaleBar } from '../model/scale.js';
import { signed } from '../model/words.js';
import { el, setShown, setText } from '../common/dom.js';

const MOST_SCALE_PX = 110;

// Beside those of the layers: what is always shown.
const MARKS: readonly [mark: string, label: string, simulated?: true][] = [
  ['robot', 'Robot, estimated pose'],
  ['doubt', 'Uncertainty (2 σ)'],
  ['truth', 'Where it truly is', true],
  ['goal', 'Goal, or chosen place'],
  ['route', 'Route, its waypoints'],
  ['dock', 'Dock, where the robot stands in it'],
  ['path', 'Path'],
  ['bubbles', 'Elastic band\'s bubbles'],
  ['tree', 'Search tree'],
  ['scan', 'Laser scan'],
  ['particles', 'Particles'],
  ['zone-keep-out', 'Zone: keep out'],
  ['zone-speed', 'Zone: slow'],
  ['zone-one-way', 'Zone: one way'],
  ['cost-map', 'Local costmap: mapped, kept out'],
  ['cost-seen', 'Local costmap: seen'],
  ['blockages', 'Remembered blockage'],
  ['box', 'Added box', true],
  ['free', 'Free ground'],
  ['occupied', 'Occupied or no room'],
];

const KEYS: readonly [keys: string, what: string][] = [
  ['Drag, wheel, pinch', 'move, zoom'],
  ['Right drag, two fingers', 'turn'],
  ['Arrows, + −', 'move, zoom'],
  ['G', 'send a goal'],
  ['P', 'set the pose'],
  ['Z', 'draw a zone'],
  ['R', 'draw a route'],
  ['K', 'draw a dock'],
  ['Enter', 'place under the cross'],
  ['Esc', 'put the tool away'],
  ['Space', 'pause, resume'],
  ['X', 'stop, until it is released'],
  ['F', 'follow the robot'],
  ['T, D', 'from the top, in 3D'],
  ['L, ?', 'layers, this help'],
];

export class MapHelp {
  readonly element: HTMLDetailsElement;
  private readonly ramp = el('span', {
    class: 'ramp', attributes: { 'aria-hidden': 'true' } });
  private readonly low = el('span', { class: 'value' });
  private readonly high = el('span', { class: 'value' });
  private readonly simulated: HTMLElement[] = [];

  constructor() {
    const marks = MARKS.map(([mark, label, isSimulated]) => {
      const row = el('li', { class: 'mark-row' },
          el('span', { class: 'swatch', attributes: {
            'data-mark': mark, 'aria-hidden': 'true' } }), label);
      if (isSimulated) this.simulated.push(row);
      return row;
    });
    this.element = el('details', { class: 'popup', id: 'help' },
        el('summary', { class: 'chip', attributes: {
          'aria-label': 'Legend and keys', 'title': 'Legend and keys' } }, '?'),
        el('div', { class: 'popover' },
            el('h3', {}, 'Colours'),
            el('p', { class: 'ramp-row' }, this.low, this.ramp, this.high),
            el('p', { class: 'detail' }, 'OctoMap, by height'),
            el('ul', { class: 'marks' }, ...marks),
            el('h3', {}, 'Mouse, fingers and keys'),
            el('dl', { class: 'keys' }, ...KEYS.flatMap(([keys, what]) =>
              [el('dt', {}, keys), el('dd', {}, what)]))));
  }

  // What the OctoMap's colours reach from and to (m).
  setHeights(low: number, high: number): void {
    setText(this.low, `${signed(low, 1)} m`);
    setText(this.high, `${signed(high, 1)} m`);
    const stops = Array.from({ length: 9 },
        (_, i) => `rgb(${heightColour(heightShare(i / 8)).join(' ')})`);
    this.ramp.style.background = `linear-gradient(90deg, ${stops.join(', ')})`;
  }

  setSimulated(isSimulated: boolean): void {
    for (const row of this.simulated) setShown(row, isSimulated);
  }
}

// How long a metre is in the middle of the picture.
export class Scale {
  readonly element: HTMLElement;
  private readonly text = el('span');
  private pixels = 0;

  constructor() {
    this.element = el('div', { class: 'scale', id: 'scale', attributes: {
      title: 'In the middle of the picture' } }, this.text);
  }

  set(pixelsPerMetre: number): void {
    const { pixels, text } = scaleBar(pixelsPerMetre, MOST_SCALE_PX);
    setText(this.text, text);
    if (pixels === this.pixels) return;
    this.pixels = pixels;
    this.element.style.width = `${pixels}px`;
  }
}
