// A loupe over the picture that was located: its pixels, those that were
// looked at, and how far each lies from where the answer expects it.

import { el, setShown, setText } from '../common/dom.js';
import { loupeInWords, loupeView, type LoupeView } from '../model/loupe.js';
import type { LocatedPicture, PixelPoint } from '../model/pin.js';
import { AGREED, DISAGREED, OUTLINE } from './points.js';

// Of the screen.
const SIDE_PX = 208;
// Screen for one pixel of the picture.
const ZOOM = 4;
const RADIUS_PX = 5;

export class Loupe {
  readonly element: HTMLElement;
  private readonly canvas = el('canvas', { class: 'loupe-picture',
    attributes: { 'aria-hidden': 'true' } });
  private readonly words = el('p', { class: 'loupe-words', id: 'loupe-words',
    attributes: { role: 'status' } });
  private readonly scale = Math.min(2, window.devicePixelRatio);

  constructor() {
    this.element =
        el('div', { class: 'loupe', id: 'loupe' }, this.canvas, this.words);
    this.canvas.width = this.canvas.height = SIDE_PX * this.scale;
    setShown(this.element, false);
  }

  hide(): void {
    setShown(this.element, false);
    setText(this.words, '');
  }

  /** `still` has the picture; `centre` is a point of it. */
  show(picture: LocatedPicture, still: HTMLCanvasElement,
      centre: PixelPoint): void {
    const view = loupeView(picture, centre, SIDE_PX / 2 / ZOOM);
    setShown(this.element, true);
    // Not over what it shows.
    this.element.classList.toggle('loupe-right',
        centre.xPx < picture.camera.widthPx / 2);
    setText(this.words, loupeInWords(view));
    this.draw(view, still, centre);
  }

  private draw({ points }: LoupeView, still: HTMLCanvasElement,
      centre: PixelPoint): void {
    const context = this.canvas.getContext('2d')!;
    const zoom = ZOOM * this.scale;
    const side = this.canvas.width;
    const of = ({ xPx, yPx }: PixelPoint) => [
      side / 2 + (xPx - centre.xPx) * zoom,
      side / 2 + (yPx - centre.yPx) * zoom] as const;
    context.fillStyle = '#000';
    context.fillRect(0, 0, side, side);
    context.imageSmoothingEnabled = false;
    // Pixel centres are whole numbers, so that a picture begins at -0.5.
    const [left, top] = of({ xPx: -0.5, yPx: -0.5 });
    context.drawImage(still, left, top, still.width * zoom,
        still.height * zoom);
    const radius = RADIUS_PX * this.scale;
    for (const isAbove of [false, true]) {
      for (const { at, expected, agrees } of points) {
        if (agrees !== isAbove) continue;
        const [x, y] = of(at);
        const mark = new Path2D();
        if (agrees) {
          mark.arc(x, y, radius, 0, 2 * Math.PI);
        } else {
          mark.moveTo(x - radius, y - radius);
          mark.lineTo(x + radius, y + radius);
          mark.moveTo(x - radius, y + radius);
          mark.lineTo(x + radius, y - radius);
        }
        if (expected !== null) {
          mark.moveTo(x, y);
          mark.lineTo(...of(expected));
        }
        for (const [width, colour] of
          [[5, OUTLINE], [2, agrees ? AGREED : DISAGREED]] as const) {
          context.lineWidth = width * this.scale;
          context.strokeStyle = colour;
          context.stroke(mark);
        }
      }
    }
  }
}
