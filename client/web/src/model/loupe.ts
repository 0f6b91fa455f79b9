// What a loupe over the picture shows: which pixels agree with the answer.

import { project, type LocatedPicture, type PixelPoint } from './pin.js';

export interface LoupePoint {
  /** Where the picture has it. */
  readonly at: PixelPoint;
  /** Where the answer's pose has it; null: behind the camera. */
  readonly expected: PixelPoint | null;
  readonly agrees: boolean;
}

export interface LoupeView {
  readonly points: readonly LoupePoint[];
  readonly agreeing: number;
}

/** Within `radiusPx` of a point of the picture. */
export function loupeView(picture: LocatedPicture, centre: PixelPoint,
    radiusPx: number): LoupeView {
  // Several of the model's points may be looked for at one pixel.
  const pixels = new Map<string, LoupePoint>();
  for (const { xPx, yPx, pointInWorldM, inlier } of picture.correspondences) {
    if (Math.hypot(xPx - centre.xPx, yPx - centre.yPx) > radiusPx) continue;
    const pixel = `${xPx} ${yPx}`;
    if (pixels.get(pixel)?.agrees || (pixels.has(pixel) && !inlier)) continue;
    pixels.set(pixel, { at: { xPx, yPx },
      expected: project(picture, pointInWorldM), agrees: inlier });
  }
  const points = [...pixels.values()];
  return { points,
    agreeing: points.filter(({ agrees }) => agrees).length };
}

export const loupeInWords = ({ points, agreeing }: LoupeView): string =>
  points.length === 0 ? 'No pixel was looked at here.' :
    `${agreeing} of ${points.length} pixels agree here.`;
