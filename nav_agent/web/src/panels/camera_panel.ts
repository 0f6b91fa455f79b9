// What the camera sees, and what the server made of the last picture.

import { ApiError, type AgentClient } from '../api/client.js';
import type { RobotState } from '../api/types.js';
import { percent, sayFix } from '../model/words.js';
import { card, el, Meter, setData, setShown, setText } from '../common/dom.js';

type Picture = 'camera' | 'query';
// Between the end of one fetch and the next.
const PERIOD_MS = 400;
const REST_MS = 5000;

const NO_CAMERA = 'This robot has no camera picture.';
const NOT_SENT = 'No picture was sent to the server yet.';

export class CameraPanel {
  readonly element: HTMLElement;
  private readonly image =
      el('img', { class: 'camera', attributes: { alt: '' } });
  private readonly empty = el('p', { class: 'camera-empty' },
      'No picture yet.');
  private readonly live: HTMLButtonElement;
  private readonly query: HTMLButtonElement;
  private readonly verdict = el('p', { class: 'detail', id: 'fix' });
  private readonly inliers = new Meter('Share of points that agree');
  private readonly inliersText = el('span', { class: 'value' });
  private readonly confidence = new Meter('Confidence of the answer');
  private readonly confidenceText = el('span', { class: 'value' });
  private readonly figures: HTMLElement;
  private picture: Picture = 'camera';
  private url = '';
  private timer = 0;
  private isLive = false;
  private isAsked = false;
  // Whether the camera has taken a picture.
  private hasCamera = false;
  private server = '';

  constructor(private readonly client: AgentClient) {
    this.live = this.tab('Live', 'camera');
    this.query = this.tab('Last question', 'query');
    this.figures = el('div', { class: 'fix-figures' },
        el('span', {}, 'Points that agree (green dots)'), this.inliers.element,
        this.inliersText,
        el('span', {}, 'Confidence'), this.confidence.element,
        this.confidenceText);
    this.element = card('Camera', 'camera',
        el('div', { class: 'tabs', attributes: { role: 'group',
          'aria-label': 'Picture' } }, this.live, this.query),
        el('div', { class: 'camera-frame' }, this.image, this.empty),
        this.verdict, this.figures);
    this.image.hidden = true;
    this.choose('camera');
  }

  private tab(label: string, picture: Picture): HTMLButtonElement {
    return el('button', {
      class: 'tab', attributes: { type: 'button' },
      on: { click: () => this.choose(picture) },
    }, label);
  }

  private choose(picture: Picture): void {
    this.picture = picture;
    this.live.setAttribute('aria-pressed', String(picture === 'camera'));
    this.query.setAttribute('aria-pressed', String(picture === 'query'));
    if (this.isLive) void this.refresh();
  }

  // Fetches only while somebody can look.
  setLive(isLive: boolean): void {
    if (this.isLive === isLive) return;
    this.isLive = isLive;
    window.clearTimeout(this.timer);
    if (isLive) void this.refresh();
  }

  private async refresh(): Promise<void> {
    window.clearTimeout(this.timer);
    let wait = PERIOD_MS;
    const wanted = this.picture;
    if (!document.hidden && !this.isThere(wanted)) {
      this.showNone(wanted === 'camera' ? NO_CAMERA : NOT_SENT);
    } else if (!document.hidden) {
      try {
        const blob = await this.client.picture(`api/${wanted}.jpg`);
        if (wanted === this.picture) this.show(blob);
      } catch (error) {
        wait = REST_MS;
        if (wanted === this.picture) this.sayError(error);
      }
    }
    if (!this.isLive) return;
    window.clearTimeout(this.timer);
    this.timer = window.setTimeout(() => void this.refresh(), wait);
  }

  private show(blob: Blob): void {
    const old = this.url;
    this.url = URL.createObjectURL(blob);
    this.image.src = this.url;
    this.image.alt = this.picture === 'camera' ?
        'What the robot\'s camera sees' : 'The last picture sent to the server';
    if (old !== '') URL.revokeObjectURL(old);
    setShown(this.image, true);
    setShown(this.empty, false);
  }

  // What is not there is not asked for either.
  private isThere(picture: Picture): boolean {
    return picture === 'camera' ? this.hasCamera : this.isAsked;
  }

  private sayError(error: unknown): void {
    const isNone = error instanceof ApiError && error.code !== 'unreachable' &&
        error.code !== 'timeout';
    this.showNone(!isNone ? 'The picture cannot be fetched.' :
        this.picture === 'camera' ? NO_CAMERA : NOT_SENT);
  }

  private showNone(why: string): void {
    setText(this.empty, why);
    setShown(this.image, false);
    setShown(this.empty, true);
  }

  // HOST:PORT of the server that is asked; '' if there is none.
  setServer(server: string): void {
    this.server = server;
    if (!this.isAsked) this.sayUnasked();
  }

  private sayUnasked(): void {
    setText(this.verdict, this.server === '' ?
        'No server: a lost robot looks around with its laser alone.' :
        'The server was not asked yet.');
    setData(this.verdict, 'tone', 'calm');
  }

  update({ devices, fix }: RobotState): void {
    this.hasCamera = devices.some(
        ({ name, state }) => name === 'camera' && state !== 'starting');
    setShown(this.figures, fix !== null);
    this.isAsked = fix !== null;
    if (fix === null) {
      this.sayUnasked();
      return;
    }
    const parts = [sayFix(fix)];
    if (fix.scene !== '') parts.push(fix.scene);
    if (fix.roundTrip !== null) {
      parts.push(`${Math.round(1000 * fix.roundTrip)} ms`);
    }
    setText(this.verdict, parts.join(' · '));
    setData(this.verdict, 'tone', fix.localized ? 'calm' : 'warn');
    const share = fix.inliers !== null && fix.samples ?
        fix.inliers / fix.samples : 0;
    this.inliers.set(share, 'busy');
    setText(this.inliersText, fix.inliers === null ? '–' :
        fix.samples ? `${fix.inliers} of ${fix.samples}` : `${fix.inliers}`);
    this.confidence.set(fix.confidence ?? 0, 'busy');
    setText(this.confidenceText,
        fix.confidence === null ? '–' : percent(fix.confidence));
  }
}
