// One click or drag on the map: a place, or a place and a heading.

import {
  CLICK_PIXELS, headingOf, headingTowards, type Place,
} from '../model/gesture.js';
import type { MapView } from './map_view.js';

export interface Placed {
  x: number;
  y: number;
  yaw: number;
  // Whether the heading was chosen, too.
  isAimed: boolean;
}

interface Drag {
  pointer: number;
  clientX: number;
  clientY: number;
  at: { x: number; y: number; z: number };
  yaw: number;
  isAimed: boolean;
}

export class Placing {
  private drag: Drag | null = null;
  private isOn = false;

  // `robot`: where it stands, for the heading of a goal that is only clicked.
  constructor(
      private readonly view: MapView,
      private readonly robot: () => Place | null,
      private readonly place: (placed: Placed) => void) {
    const { canvas } = view;
    canvas.addEventListener('pointerdown', (event) => this.begin(event));
    canvas.addEventListener('pointermove', (event) => this.move(event));
    canvas.addEventListener('pointerup', (event) => this.end(event));
    canvas.addEventListener('pointercancel', () => this.stop());
    canvas.addEventListener('keydown', (event) => {
      if (event.key === 'Enter') this.placeInMiddle();
    });
  }

  enable(isOn: boolean): void {
    this.isOn = isOn;
    this.view.giveFirstButtonTo(isOn ? 'tool' : 'map');
    this.stop();
  }

  private stop(): void {
    this.drag = null;
    this.view.choice.hide();
    this.view.draw();
  }

  // By keyboard: under the cross in the middle of the map.
  private placeInMiddle(): void {
    if (!this.isOn) return;
    const box = this.view.canvas.getBoundingClientRect();
    const at = this.view.groundUnder(
        box.left + box.width / 2, box.top + box.height / 2);
    if (at === null) return;
    this.place({ x: at.x, y: at.y, yaw: headingTowards(this.robot(), at),
      isAimed: false });
  }

  private begin(event: PointerEvent): void {
    // A second finger means that the map is moved.
    if (this.drag !== null) {
      this.stop();
      return;
    }
    if (!this.isOn || event.button !== 0 || !event.isPrimary) return;
    const at = this.view.groundUnder(event.clientX, event.clientY);
    if (at === null) return;
    this.drag = {
      pointer: event.pointerId, clientX: event.clientX, clientY: event.clientY,
      at, yaw: headingTowards(this.robot(), at), isAimed: false,
    };
    this.view.choice.show(at.x, at.y, at.z, this.drag.yaw);
    this.view.draw();
  }

  private move(event: PointerEvent): void {
    const { drag } = this;
    if (drag === null || drag.pointer !== event.pointerId) return;
    this.aim(drag, event);
    this.view.choice.show(drag.at.x, drag.at.y, drag.at.z, drag.yaw);
    this.view.draw();
  }

  private aim(drag: Drag, event: PointerEvent): void {
    const to = this.view.groundUnder(event.clientX, event.clientY);
    if (to === null) return;
    const pixels = Math.hypot(
        event.clientX - drag.clientX, event.clientY - drag.clientY);
    drag.isAimed = pixels >= CLICK_PIXELS;
    drag.yaw = headingOf(
        drag.at, to, pixels, headingTowards(this.robot(), drag.at));
  }

  private end(event: PointerEvent): void {
    const { drag } = this;
    if (drag === null || drag.pointer !== event.pointerId) return;
    this.aim(drag, event);
    this.stop();
    this.place({ x: drag.at.x, y: drag.at.y, yaw: drag.yaw,
      isAimed: drag.isAimed });
  }
}
