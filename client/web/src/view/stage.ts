// The video with everything that lies over it, and the pointing at it.

import type { RigidTransform, SceneMap } from '@treeline/client';

import { button, el, setShown } from '../common/dom.js';
import type { Note } from '../model/notes.js';
import { project, type LocatedPicture, type PixelPoint } from '../model/pin.js';
import type { Bounds, UpAxis } from '../model/scene_up.js';
import { Loupe } from './loupe.js';
import { Overlay, type OverlayLayer } from './overlay.js';
import { drawPoints } from './points.js';

// Those that this file draws itself.
type PictureLayer = 'points' | 'still' | 'loupe';
export type Layer = OverlayLayer | PictureLayer;

const isPictureLayer = (layer: Layer): layer is PictureLayer =>
  layer === 'points' || layer === 'still' || layer === 'loupe';

export interface StageEvents {
  readonly onPoint: (at: PixelPoint) => void;
  readonly onNote: (note: Note) => void;
}

// Of the picture, for one press of an arrow key.
const STEP_SHARE = 0.02;

const ARROWS: Readonly<Record<string, readonly [x: number, y: number]>> = {
  ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1],
};

export class Stage {
  readonly element: HTMLElement;
  readonly video = el('video', { class: 'video', attributes: {
    'playsinline': '', 'aria-label': 'What the camera sees' } });
  private readonly overlay = new Overlay();
  private readonly still =
      el('canvas', { class: 'still', attributes: { 'aria-hidden': 'true' } });
  private readonly points =
      el('canvas', { class: 'points', attributes: { 'aria-hidden': 'true' } });
  private readonly cross =
      el('div', { class: 'cross', attributes: { 'aria-hidden': 'true' } });
  private readonly labels = el('div', { class: 'labels' });
  private readonly target: HTMLElement;
  private readonly frame: HTMLElement;
  private readonly shown = { points: false, still: false, loupe: false };
  private readonly loupe = new Loupe();
  private notes: readonly Note[] = [];
  private picture: LocatedPicture | null = null;
  private isStarted = false;
  private isInSpace = false;
  private crossX = 0.5;
  private crossY = 0.5;

  constructor(private readonly events: StageEvents, empty: HTMLElement) {
    this.target = el('div', {
      class: 'target', id: 'target',
      attributes: { 'tabindex': '0', 'role': 'application', 'aria-label':
        'Picture. The arrow keys move the cross, Enter pins a note there.' },
      on: {
        click: (event) => this.onClick(event),
        keydown: (event) => this.onKey(event),
        pointermove: (event) => this.onPointer(event),
      },
    }, this.cross);
    this.frame = el('div', { class: 'frame', id: 'frame' }, this.video,
        this.still, this.overlay.canvas, this.points, this.target, this.labels,
        this.loupe.element);
    this.element = el('section', { class: 'stage',
      attributes: { 'aria-label': 'Camera' } }, this.frame, empty);
    this.video.muted = true;
    new ResizeObserver(() => this.resize()).observe(this.element);
    this.video.addEventListener('resize', () => this.resize());
    this.moveCross(0, 0);
    this.setStarted(false);
  }

  setStarted(isStarted: boolean): void {
    this.isStarted = isStarted;
    setShown(this.frame, isStarted);
    this.setPicture(null, null);
    this.resize();
  }

  /** What a session in the space around the device is drawn with. */
  get renderer() {
    return this.overlay.renderer;
  }

  async enterSpace(session: XRSession): Promise<void> {
    await this.overlay.present(session);
    this.isInSpace = true;
    setShown(this.frame, true);
    setShown(this.video, false);
    this.resize();
  }

  leaveSpace(): void {
    if (!this.isInSpace) return;
    this.isInSpace = false;
    this.overlay.leaveSpace();
    setShown(this.video, true);
    this.setStarted(false);
  }

  /** In each frame of the session. */
  drawSpace(picture: LocatedPicture | null,
      worldFromDevice: RigidTransform | null): void {
    this.picture = picture;
    this.placeLabels();
    this.placeLayers();
    this.overlay.drawSpace(worldFromDevice);
  }

  setScene(bounds: Bounds | null, up: UpAxis): void {
    this.overlay.setScene(bounds, up);
  }

  setMap(map: SceneMap | null): void {
    this.overlay.setMap(map);
  }

  setNotes(notes: readonly Note[]): void {
    this.notes = notes;
    this.overlay.setNotes(notes);
    this.labels.replaceChildren(...notes.map((note) => button(note.text,
        () => this.events.onNote(note), { class: 'label' })));
    this.placeLabels();
  }

  show(layer: Layer, isShown: boolean): void {
    if (isPictureLayer(layer)) {
      this.shown[layer] = isShown;
      this.placeLayers();
    } else {
      this.overlay.show(layer, isShown);
    }
  }

  /** `jpeg`: the picture as it was sent. Null: not located. */
  setPicture(picture: LocatedPicture | null, jpeg: Blob | null): void {
    this.picture = picture;
    this.overlay.setPicture(picture);
    this.placeLabels();
    this.placeLayers();
    if (jpeg !== null) void this.drawStill(jpeg);
  }

  /** Where the cross is in the picture that was located; null: nowhere. */
  get crossPoint(): PixelPoint | null {
    return this.pointOfShare(this.crossX, this.crossY);
  }

  focus(): void {
    this.target.focus();
  }

  /** Where a point of the world is drawn, as a share of the picture. */
  shareOf(x: number, y: number, z: number): { x: number; y: number } | null {
    return this.overlay.shareOf(x, y, z);
  }

  private async drawStill(jpeg: Blob): Promise<void> {
    const bitmap = await createImageBitmap(jpeg);
    this.still.width = bitmap.width;
    this.still.height = bitmap.height;
    this.still.getContext('2d')!.drawImage(bitmap, 0, 0);
    bitmap.close();
    this.placeLoupe();
  }

  private placeLoupe(): void {
    const { picture, crossPoint } = this;
    if (!this.shown.loupe || this.isInSpace || picture === null ||
        crossPoint === null) {
      this.loupe.hide();
    } else {
      this.loupe.show(picture, this.still, crossPoint);
    }
  }

  private placeLayers(): void {
    setShown(this.still,
        this.shown.still && this.picture !== null && !this.isInSpace);
    this.placeLoupe();
    const isPointed = this.shown.points && this.picture !== null;
    setShown(this.points, isPointed);
    if (isPointed) {
      drawPoints(this.points, this.picture!.correspondences,
          this.picture!.camera.widthPx);
    }
  }

  private placeLabels(): void {
    const { picture } = this;
    for (const [i, note] of this.notes.entries()) {
      const label = this.labels.children[i] as HTMLElement;
      const at = picture && project(picture, note.pointInWorldM);
      const x = at === null ? -1 : (at.xPx + 0.5) / picture!.camera.widthPx;
      const y = at === null ? -1 : (at.yPx + 0.5) / picture!.camera.heightPx;
      setShown(label, x >= 0 && x <= 1 && y >= 0 && y <= 1);
      label.style.setProperty('--x', `${100 * x}%`);
      label.style.setProperty('--y', `${100 * y}%`);
    }
  }

  private pointOfShare(x: number, y: number): PixelPoint | null {
    if (this.picture === null) return null;
    const { widthPx, heightPx } = this.picture.camera;
    return { xPx: x * widthPx - 0.5, yPx: y * heightPx - 0.5 };
  }

  private onClick(event: MouseEvent): void {
    this.crossTo(event);
    this.point();
  }

  private onPointer(event: MouseEvent): void {
    if (this.shown.loupe) this.crossTo(event);
  }

  private crossTo(event: MouseEvent): void {
    const box = this.target.getBoundingClientRect();
    this.crossX = (event.clientX - box.left) / box.width;
    this.crossY = (event.clientY - box.top) / box.height;
    this.moveCross(0, 0);
  }

  private onKey(event: KeyboardEvent): void {
    const arrow = ARROWS[event.key];
    if (arrow !== undefined) {
      this.moveCross(...arrow);
    } else if (event.key === 'Enter' || event.key === ' ') {
      this.point();
    } else {
      return;
    }
    event.preventDefault();
  }

  private point(): void {
    const at = this.crossPoint;
    if (at !== null) this.events.onPoint(at);
  }

  private moveCross(x: number, y: number): void {
    const within = (share: number) => Math.min(1, Math.max(0, share));
    this.crossX = within(this.crossX + x * STEP_SHARE);
    this.crossY = within(this.crossY + y * STEP_SHARE);
    this.cross.style.left = `${100 * this.crossX}%`;
    this.cross.style.top = `${100 * this.crossY}%`;
    this.placeLoupe();
  }

  // The frame is as large as the stage allows, in the shape of the video.
  private resize(): void {
    const { videoWidth, videoHeight } = this.video;
    const { clientWidth, clientHeight } = this.element;
    if (this.isInSpace) {
      this.fit(clientWidth, clientHeight);
      return;
    }
    if (!this.isStarted || videoWidth === 0 || clientWidth === 0) return;
    const scale =
        Math.min(clientWidth / videoWidth, clientHeight / videoHeight);
    this.fit(Math.round(videoWidth * scale), Math.round(videoHeight * scale));
  }

  private fit(widthPx: number, heightPx: number): void {
    this.frame.style.width = `${widthPx}px`;
    this.frame.style.height = `${heightPx}px`;
    this.points.width = widthPx * window.devicePixelRatio;
    this.points.height = heightPx * window.devicePixelRatio;
    this.overlay.resize(widthPx, heightPx);
    this.placeLayers();
  }
}
