// Where the world may be, and which fixes say so.

import { addMatrices } from '../geometry/matrix.js';
import { compose, inverse, type RigidTransform } from
  '../geometry/rigid_transform.js';
import { angleBetweenRad } from '../geometry/rotation.js';
import { norm, subtract } from '../geometry/vector3.js';
import { fused, transported, type GaussianPose } from './gaussian_pose.js';
import { radians, type DriftParameters } from './parameters.js';
import type { TrackedPose } from './track_history.js';

/** A fix, carried along the tracking to the newest tracked pose. */
export interface CarriedFix {
  readonly now: GaussianPose;
  readonly confidence: number;
  readonly captured: TrackedPose;
}

const areDistinct = (a: RigidTransform, b: RigidTransform, distanceM: number,
    angleDeg: number): boolean =>
  norm(subtract(a.translationM, b.translationM)) >= distanceM ||
  angleBetweenRad(a.rotation, b.rotation) >= radians(angleDeg);

// deviceFromCamera of views, no two of which are alike. No more are kept than
// are asked for, so that neither memory nor work grows with time.
class Views {
  private readonly views: RigidTransform[] = [];

  constructor(private readonly enough: number,
      private readonly distanceM: number, private readonly angleDeg: number) {}

  get count(): number {
    return this.views.length;
  }

  get areEnough(): boolean {
    return this.count >= this.enough;
  }

  add(view: RigidTransform): void {
    if (this.areEnough) return;
    if (this.views.every((other) =>
      areDistinct(view, other, this.distanceM, this.angleDeg))) {
      this.views.push(view);
    }
  }
}

export class Hypothesis {
  private current: GaussianPose;
  private lastView: RigidTransform;
  private logOdds = 0;
  private fixes = 0;
  private supportedMs: number;
  private readonly lockViews: Views;
  private readonly contradictionViews: Views;

  constructor(first: CarriedFix, private readonly parameters: DriftParameters) {
    const p = parameters;
    this.current = first.now;
    this.lastView = first.captured.deviceFromCamera;
    this.supportedMs = first.captured.timeMs;
    this.lockViews = new Views(p.lockViews, p.lockViewM, p.lockViewDeg);
    this.contradictionViews = new Views(
        p.contradictionViews, p.contradictionViewM, p.contradictionViewDeg);
    this.count(first);
  }

  /** worldFromCamera at the newest tracked pose. */
  get pose(): GaussianPose {
    return this.current;
  }

  /** Capture time of the newest fix that supports it. */
  get lastSupportMs(): number {
    return this.supportedMs;
  }

  get fixCount(): number {
    return this.fixes;
  }

  get contradictionViewCount(): number {
    return this.contradictionViews.count;
  }

  /** Along the tracking to its newest pose, whose drift since is `drift`. */
  follow(from: TrackedPose, to: TrackedPose, drift: readonly number[]): void {
    const worldFromCamera = compose(
        compose(this.current.worldFromCamera,
            inverse(from.deviceFromCamera)),
        to.deviceFromCamera);
    const movedM = subtract(worldFromCamera.translationM,
        this.current.worldFromCamera.translationM);
    this.current = {
      worldFromCamera,
      covariance:
          addMatrices(transported(this.current.covariance, movedM), drift),
    };
  }

  /** Takes a fix that agrees into account. */
  support(fix: CarriedFix): void {
    const p = this.parameters;
    const view = fix.captured.deviceFromCamera;
    const factor =
        areDistinct(view, this.lastView, p.lockViewM, p.lockViewDeg) ? 1 :
          p.repeatedViewFactor;
    this.current = fused(this.current, {
      worldFromCamera: fix.now.worldFromCamera,
      covariance: fix.now.covariance.map((value) => value * factor),
    });
    this.lastView = view;
    this.supportedMs = Math.max(this.supportedMs, fix.captured.timeMs);
    this.count(fix);
  }

  /** Whether its fixes are enough for a world to begin with. */
  mayLock(): boolean {
    const p = this.parameters;
    return this.areOddsEnough() &&
        (this.lockViews.areEnough || this.fixes >= p.lockFixes);
  }

  /** Whether its fixes are enough against a world that contradicts them. */
  mayContradict(): boolean {
    return this.areOddsEnough() && this.contradictionViews.areEnough;
  }

  private areOddsEnough(): boolean {
    return this.logOdds >= Math.log(this.parameters.minOdds);
  }

  private count({ confidence, captured }: CarriedFix): void {
    const { maxOddsOfFix } = this.parameters;
    const odds = confidence * (1 + maxOddsOfFix) >= maxOddsOfFix ?
      maxOddsOfFix : confidence / (1 - confidence);
    this.logOdds += Math.log(odds);
    this.fixes += 1;
    this.lockViews.add(captured.deviceFromCamera);
    this.contradictionViews.add(captured.deviceFromCamera);
  }
}
