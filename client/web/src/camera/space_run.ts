// One session in the space around the device: its own tracking moves the
// drawing in each frame, and answers of the server say where that is.

import { DriftCorrector, fixOf, type Correspondence, type DriftEstimate,
  type DriftState, type LocalizeAnswer } from '@treeline/client';

import { seenAgain, type LocatedPicture } from '../model/pin.js';
import type { Stage } from '../view/stage.js';
import type { TrackedView } from './device_camera.js';
import { SpaceCamera } from './space_camera.js';

// Of the page while the space is seen through it.
const IN_SPACE = 'in-space';

export interface SpaceEvents {
  readonly onState: (state: DriftState) => void;
  /** The device, or its user, has ended it. */
  readonly onEnd: () => void;
}

export class SpaceRun {
  readonly camera: SpaceCamera;
  private readonly corrector = new DriftCorrector();
  private estimate: DriftEstimate | null = null;
  private view: TrackedView | null = null;
  private correspondences: readonly Correspondence[] = [];
  private lastMs = -Infinity;
  private isOver = false;

  constructor(private readonly session: XRSession,
      private readonly stage: Stage, private readonly events: SpaceEvents) {
    this.camera = new SpaceCamera(stage.renderer);
  }

  async begin(): Promise<void> {
    this.session.addEventListener('end', () => this.onEnd());
    await this.stage.enterSpace(this.session);
    document.body.classList.add(IN_SPACE);
    const { renderer } = this.stage;
    renderer.xr.getReferenceSpace()?.addEventListener(
        'reset', () => this.corrector.trackingReset());
    renderer.setAnimationLoop((timeMs, frame) => {
      if (frame !== undefined && !this.isOver) this.onFrame(timeMs, frame);
    });
  }

  get state(): DriftState {
    return this.corrector.state;
  }

  /** What the camera sees now; null: not known where it is. */
  get picture(): LocatedPicture | null {
    const { view, estimate, correspondences } = this;
    if (view === null || estimate?.worldFromCamera == null) return null;
    const picture = { camera: view.camera,
      worldFromCamera: estimate.worldFromCamera, correspondences };
    // Only who asks pays for it.
    return { ...picture,
      get correspondences() { return seenAgain(picture); } };
  }

  add(answer: LocalizeAnswer, captureTimeMs: number): void {
    const fix = fixOf(answer, captureTimeMs);
    if (fix === null) return;
    this.corrector.addFix(fix);
    this.correspondences = answer.correspondences;
  }

  end(): void {
    if (!this.isOver) void this.session.end().catch(() => this.onEnd());
  }

  private onFrame(timeMs: number, frame: XRFrame): void {
    // A device may show one moment twice.
    if (timeMs > this.lastMs) {
      const view = this.camera.onFrame(timeMs, frame);
      if (view !== null) {
        this.lastMs = timeMs;
        this.view = view;
        this.estimate = this.corrector.track(timeMs, view.deviceFromCamera);
        this.events.onState(this.estimate.state);
      }
    }
    this.stage.drawSpace(
        this.picture, this.estimate?.worldFromDevice ?? null);
  }

  private onEnd(): void {
    if (this.isOver) return;
    this.isOver = true;
    document.body.classList.remove(IN_SPACE);
    this.camera.stop();
    this.stage.leaveSpace();
    this.events.onEnd();
  }
}
