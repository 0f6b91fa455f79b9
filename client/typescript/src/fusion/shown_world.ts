// The worldFromDevice that content is drawn with: it follows what is known
// without steps that people see.

import { compose, inverse, type RigidTransform } from
  '../geometry/rigid_transform.js';
import { angleOfRotationRad, difference, lengthOfTranslationM, moved } from
  './gaussian_pose.js';
import { radians, type DriftParameters } from './parameters.js';

export class ShownWorld {
  private worldFromDevice: RigidTransform | null = null;

  constructor(private readonly parameters: DriftParameters) {}

  get current(): RigidTransform | null {
    return this.worldFromDevice;
  }

  clear(): void {
    this.worldFromDevice = null;
  }

  /**
   * One step of passedS towards `worldFromCamera`, which is where the camera at
   * `deviceFromCamera` is known to be. The motion is measured where people see
   * it: at the camera. Returns whether it snapped.
   */
  step(worldFromCamera: RigidTransform, deviceFromCamera: RigidTransform,
      passedS: number): boolean {
    const deviceInverse = inverse(deviceFromCamera);
    const known = compose(worldFromCamera, deviceInverse);
    if (this.worldFromDevice === null) {
      this.worldFromDevice = known;
      return true;
    }
    const shown = compose(this.worldFromDevice, deviceFromCamera);
    const delta = difference(shown, worldFromCamera);
    const distanceM = lengthOfTranslationM(delta);
    const angleRad = angleOfRotationRad(delta);
    const p = this.parameters;
    if (distanceM > p.snapM || angleRad > radians(p.snapDeg)) {
      this.worldFromDevice = known;
      return true;
    }
    const share = Math.min(1,
        distanceM > 0 ? p.maxCorrectionMps * passedS / distanceM : 1,
        angleRad > 0 ? radians(p.maxCorrectionDegps) * passedS / angleRad : 1);
    this.worldFromDevice = share === 1 ? known : compose(
        moved(shown, delta.map((value) => value * share)), deviceInverse);
    return false;
  }
}
