// The worldFromDevice that content is drawn with: it follows what is known
// without steps that people see.

import { compose, inverse, type RigidTransform } from
  '../geometry/rigid_transform.js';
import { angleOfRotationRad, difference, lengthOfTranslationM, moved } from
  './gaussian_pose.js';
import { radians, type DriftParameters } from './parameters.js';

// How much of a length is done, where `most` may be.
const shareOf = (length: number, most: number): number =>
  length > most ? most / length : 1;

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
    // Each for itself: a rotation that waited for a long way would make new
    // errors of position as the camera moves on.
    const move = shareOf(distanceM, p.maxCorrectionMps * passedS);
    const turn = shareOf(angleRad, radians(p.maxCorrectionDegps) * passedS);
    this.worldFromDevice = compose(moved(shown, delta.map(
        (value, i) => value * (i < 3 ? move : turn))), deviceInverse);
    return false;
  }
}
