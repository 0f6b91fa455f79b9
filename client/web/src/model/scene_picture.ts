// What a scene's map becomes on the screen: colours, words and the view.
// Nothing here knows of three.js.

import { rotate, type Camera, type Pinhole, type RecentQuery,
  type SceneCoverage,
  type SceneMap, type Vector3 } from '@treeline/client';

export type Rgb = readonly [r: number, g: number, b: number];

// Told apart by the colour-blind as well (Okabe and Ito).
export const COVERAGE_NONE: Rgb = [0.835, 0.369, 0];
export const COVERAGE_HALF: Rgb = [0.941, 0.894, 0.259];
export const COVERAGE_ALL: Rgb = [0, 0.62, 0.451];

const mix = (a: Rgb, b: Rgb, share: number): Rgb =>
  [0, 1, 2].map((i) => a[i]! + (b[i]! - a[i]!) * share) as unknown as Rgb;

/** By the share of headings from which queries will be answered. */
export function coverageColor(share: number): Rgb {
  return share < 0.5 ? mix(COVERAGE_NONE, COVERAGE_HALF, 2 * share) :
    mix(COVERAGE_HALF, COVERAGE_ALL, 2 * share - 1);
}

// A weak heading counts half.
export const shareOfPlace = (
    { goodHeadings, weakHeadings, headings }: SceneCoverage, i: number):
    number => (goodHeadings[i]! + weakHeadings[i]! / 2) / headings;

/** The plan as a picture: RGBA rows from the least y on; what nothing is said
 * of is transparent. */
export function coveragePixels(coverage: SceneCoverage): Uint8Array {
  const { columns, rows, isOpen } = coverage;
  const pixels = new Uint8Array(4 * columns * rows);
  for (let i = 0; i < columns * rows; ++i) {
    if (isOpen[i] === 0) continue;
    const color = coverageColor(shareOfPlace(coverage, i));
    pixels.set([...color.map((part) => Math.round(255 * part)), 255], 4 * i);
  }
  return pixels;
}

/** Gray values that stand out from the stage, whatever its tone. */
export function pointColors(brightness: Uint8Array, isDark: boolean):
    Float32Array {
  const colors = new Float32Array(3 * brightness.length);
  brightness.forEach((value, i) => {
    const share = value / 255;
    colors.fill(isDark ? 0.35 + 0.65 * share : 0.05 + 0.6 * share, 3 * i,
        3 * i + 3);
  });
  return colors;
}

export interface Ball {
  readonly centreM: Vector3;
  readonly radiusM: number;
}

// So much of the points may be far off: features that were wrong.
const OUTSIDE_SHARE = 0.02;

/** What the view must show, in the plan: cameras and nearly all points. */
export function ballOf({ pointsInWorldM, worldFromKeyframe, planFromWorld }:
    SceneMap): Ball {
  const points: Vector3[] = worldFromKeyframe.map(
      ({ translationM }) => rotate(planFromWorld, translationM));
  // A few thousand tell.
  const step = 3 * Math.max(1, Math.floor(pointsInWorldM.length / 3 / 4000));
  for (let i = 0; i + 2 < pointsInWorldM.length; i += step) {
    points.push(rotate(planFromWorld, { x: pointsInWorldM[i]!,
      y: pointsInWorldM[i + 1]!, z: pointsInWorldM[i + 2]! }));
  }
  if (points.length === 0) return { centreM: { x: 0, y: 0, z: 0 }, radiusM: 1 };
  const [x, y, z] = (['x', 'y', 'z'] as const).map((axis) => {
    const values = points.map((point) => point[axis]).sort((a, b) => a - b);
    const cut = Math.floor(values.length * OUTSIDE_SHARE);
    return [values[cut]!, values[values.length - 1 - cut]!] as const;
  }) as [readonly [number, number], readonly [number, number],
    readonly [number, number]];
  return {
    centreM: { x: (x[0] + x[1]) / 2, y: (y[0] + y[1]) / 2,
      z: (z[0] + z[1]) / 2 },
    radiusM: Math.max(0.5,
        Math.hypot(x[1] - x[0], y[1] - y[0], z[1] - z[0]) / 2),
  };
}

/** Ends of the edges of a camera's pyramid, in its own frame: 8 lines. */
export function pyramid({ widthPx, heightPx, fxPx, fyPx, cxPx, cyPx }: Pinhole,
    depthM: number): Vector3[] {
  const corner = (xPx: number, yPx: number): Vector3 => ({
    x: (xPx - cxPx) / fxPx * depthM, y: (yPx - cyPx) / fyPx * depthM,
    z: depthM });
  const corners = [corner(0, 0), corner(widthPx, 0),
    corner(widthPx, heightPx), corner(0, heightPx)];
  const origin = { x: 0, y: 0, z: 0 };
  return corners.flatMap((from, i) =>
    [from, corners[(i + 1) % 4]!, origin, from]);
}

export interface QueryCounts {
  readonly located: number;
  readonly notLocated: number;
  readonly failed: number;
}

export function countQueries(queries: readonly RecentQuery[]): QueryCounts {
  const located = queries.filter(({ reason }) => reason === '').length;
  const failed = queries.filter(({ isError }) => isError).length;
  return { located, failed, notLocated: queries.length - located - failed };
}

export const percentOf = (share: number): string =>
  `${Math.round(100 * share)} %`;

/** The scene for whoever does not see it. */
export function describeMap(map: SceneMap): string {
  const { coverage, worldFromKeyframe, pointsInModel } = map;
  const parts = [`${pointsInModel.toLocaleString('en')} points from ` +
      `${worldFromKeyframe.length} keyframes.`];
  if (coverage !== null) {
    parts.push(`Predicted for ${coverage.openM2.toFixed(1)} m²: ` +
        `${percentOf(coverage.goodShare)} of the views will be answered, ` +
        `${percentOf(coverage.weakShare)} perhaps.`);
  }
  return parts.join(' ');
}

/** Of any model, without its distortion: for drawings. */
export function pinholeOf({ model, widthPx, heightPx, parameters }: Camera):
    Pinhole {
  // Models that begin with SIMPLE_, and RADIAL, have one focal length.
  const hasOne = model.startsWith('SIMPLE_') || model.startsWith('RADIAL');
  const [fxPx = widthPx, fyPx = fxPx, cxPx = widthPx / 2, cyPx = heightPx / 2] =
      hasOne ? [parameters[0], ...parameters] : parameters;
  return { widthPx, heightPx, fxPx, fyPx, cxPx, cyPx };
}
