// A pad to drive the robot by hand. It moves while the pad or a key is held,
// and stands when it is let go, when the page loses the focus, and when it is
// hidden.

import { ApiError } from '../api/client.js';
import { button, card, el, setData, setText } from '../common/dom.js';
import {
  HandDrive, isDrivingKey, PERIOD_MS, velocityOf, velocityOfKeys,
  type Velocity,
} from '../model/hand_drive.js';

// What the agent or the line says of one command alone.
const PASSING: readonly string[] =
    ['aborted', 'canceled', 'deadline_exceeded', 'timeout'];

const AT_REST = 'Hold and drag, or the arrow keys.';

export class DrivePanel {
  readonly element: HTMLElement;
  private readonly knob = el('span', {
    class: 'knob', attributes: { 'aria-hidden': 'true' } });
  private readonly pad: HTMLButtonElement;
  private readonly text = el('p', { class: 'detail', id: 'drive-text' },
      AT_REST);
  private readonly drive: HandDrive;
  private readonly keys = new Set<string>();
  private pointer: number | null = null;

  constructor(
      send: (velocity: Velocity, sequence: bigint) => Promise<void>,
      refused: (error: unknown) => void) {
    this.drive = new HandDrive({
      send,
      every: (work) => {
        const timer = window.setInterval(work, PERIOD_MS);
        return () => window.clearInterval(timer);
      },
      isPassing: (error) =>
        error instanceof ApiError && PASSING.includes(error.code),
      refused: (error) => {
        this.letGo();
        refused(error);
      },
      moves: (isDriven) => setData(this.pad, 'driven', String(isDriven)),
    });
    this.pad = button('', () => {}, {
      id: 'drive-pad', class: 'pad', attributes: {
        'aria-label': 'Drive by hand: hold and drag, or hold arrow keys',
        'data-driven': 'false' } });
    this.pad.append(this.knob);
    this.element = card('Drive by hand', 'drive',
        el('div', { class: 'drive needs-link' }, this.pad, this.text));
    this.listen();
  }

  private listen(): void {
    const { pad } = this;
    pad.addEventListener('pointerdown', (event) => {
      if (this.pointer !== null || event.button !== 0) return;
      this.pointer = event.pointerId;
      pad.setPointerCapture(event.pointerId);
      this.aim(event);
    });
    pad.addEventListener('pointermove', (event) => {
      if (event.pointerId === this.pointer) this.aim(event);
    });
    for (const end of ['pointerup', 'pointercancel', 'lostpointercapture',
    ] as const) {
      pad.addEventListener(end, (event) => {
        if (event.pointerId === this.pointer) this.letGo();
      });
    }
    pad.addEventListener('contextmenu', (event) => event.preventDefault());
    pad.addEventListener('keydown', (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey ||
          !isDrivingKey(event.key)) return;
      event.preventDefault();
      event.stopPropagation();
      if (event.repeat) return;
      this.keys.add(event.key.toLowerCase());
      this.hold(velocityOfKeys(this.keys));
    });
    pad.addEventListener('keyup', (event) => {
      if (!this.keys.delete(event.key.toLowerCase())) return;
      if (this.keys.size === 0) this.letGo();
      else this.hold(velocityOfKeys(this.keys));
    });
    pad.addEventListener('blur', () => this.letGo());
    window.addEventListener('blur', () => this.letGo());
    window.addEventListener('pagehide', () => this.letGo());
    document.addEventListener('visibilitychange', () => {
      if (document.hidden) this.letGo();
    });
  }

  private aim(event: PointerEvent): void {
    const box = this.pad.getBoundingClientRect();
    const right = (event.clientX - box.x) / (box.width / 2) - 1;
    const up = 1 - (event.clientY - box.y) / (box.height / 2);
    const reach = Math.max(1, Math.hypot(right, up));
    this.knob.style.left = `${50 + 36 * right / reach}%`;
    this.knob.style.top = `${50 - 36 * up / reach}%`;
    this.hold(velocityOf(right, up));
  }

  private hold(velocity: Velocity): void {
    setText(this.text, `${velocity.forward.toFixed(2)} m/s ahead, ` +
        `${velocity.yawRate.toFixed(2)} rad/s to the left`);
    this.drive.hold(velocity);
  }

  // Whatever holds it.
  letGo(): void {
    this.pointer = null;
    this.keys.clear();
    this.knob.style.left = this.knob.style.top = '50%';
    setText(this.text, AT_REST);
    this.drive.release();
  }
}
