// The camera that is stated with a picture. Browsers do not tell the focal
// length: a field of view is guessed, and the server's answers correct it.

import { pinhole, pinholeOf, type Camera, type LocalizeAnswer, type Pinhole }
  from '@treeline/client';

/** Along the longer side. What main cameras of phones have in videos. */
export const DEFAULT_FIELD_OF_VIEW_DEG = 65;
export const MIN_FIELD_OF_VIEW_DEG = 20;
export const MAX_FIELD_OF_VIEW_DEG = 130;

const RAD = Math.PI / 180;

export const focalPxOf = (
    fieldOfViewDeg: number, widthPx: number, heightPx: number): number =>
  Math.max(widthPx, heightPx) / 2 / Math.tan(fieldOfViewDeg * RAD / 2);

export const fieldOfViewDegOf = (
    focalPx: number, widthPx: number, heightPx: number): number =>
  2 * Math.atan(Math.max(widthPx, heightPx) / 2 / focalPx) / RAD;

/** Square pixels, and the optical axis through the middle. */
export function guessedPinhole(
    fieldOfViewDeg: number, widthPx: number, heightPx: number): Pinhole {
  const focalPx = focalPxOf(fieldOfViewDeg, widthPx, heightPx);
  return { widthPx, heightPx, fxPx: focalPx, fyPx: focalPx,
    cxPx: (widthPx - 1) / 2, cyPx: (heightPx - 1) / 2 };
}

export const statedCamera = (guess: Pinhole): Camera => pinhole(guess);

/** The camera that an answer's pose is of; its distortion is small. */
export const answeredPinhole = (
    stated: Pinhole,
    { camera, focalScale }: Pick<LocalizeAnswer, 'camera' | 'focalScale'>):
    Pinhole => camera !== null ? pinholeOf(camera) : {
  ...stated,
  fxPx: stated.fxPx * focalScale,
  fyPx: stated.fyPx * focalScale,
};

/**
 * The field of view to state next, after an answer with a pose: the one that
 * fitted, within what cameras have.
 */
export const correctedFieldOfViewDeg = (
    { fxPx, widthPx, heightPx }: Pinhole): number =>
  Math.min(MAX_FIELD_OF_VIEW_DEG, Math.max(MIN_FIELD_OF_VIEW_DEG,
      fieldOfViewDegOf(fxPx, widthPx, heightPx)));

/** A picture's size within 640x480, or 480x640 if it is upright. */
export function sentSize(widthPx: number, heightPx: number):
    { widthPx: number; heightPx: number } {
  const scale = Math.min(1, 640 / Math.max(widthPx, heightPx),
      480 / Math.min(widthPx, heightPx));
  return { widthPx: Math.round(widthPx * scale),
    heightPx: Math.round(heightPx * scale) };
}
