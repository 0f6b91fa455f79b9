// Where in the world a point of the picture is.

import { inverse, rotate, transformPoint, type Correspondence, type Pinhole,
  type RigidTransform, type Vector3 } from '@treeline/client';

import { axisOf, floorM, type Bounds, type UpAxis } from './scene_up.js';

/** In the picture; the centre of the top left pixel is (0, 0). */
export interface PixelPoint {
  readonly xPx: number;
  readonly yPx: number;
}

/** One picture with its answer. */
export interface LocatedPicture {
  readonly camera: Pinhole;
  readonly worldFromCamera: RigidTransform;
  readonly correspondences: readonly Correspondence[];
}

export interface Pin {
  readonly pointInWorldM: Vector3;
  readonly from: 'points' | 'floor';
}

// As many neighbours vote on the depth; one alone may be wrong.
const NEIGHBOURS = 3;
/** Neighbours lie within this share of the picture's longer side. */
const NEAR_SHARE = 0.08;
// Beyond the bounds of what was learnt, a floor is a guess.
const MAX_FLOOR_DISTANCE_M = 30;

export function project({ camera, worldFromCamera }: LocatedPicture,
    pointInWorldM: Vector3): PixelPoint | null {
  const { x, y, z } = transformPoint(inverse(worldFromCamera), pointInWorldM);
  if (z <= 0) return null;
  return { xPx: camera.fxPx * x / z + camera.cxPx,
    yPx: camera.fyPx * y / z + camera.cyPx };
}

/**
 * What another picture showed, where this camera sees it now; what lies behind
 * it is left out.
 */
export const seenAgain = (
    picture: LocatedPicture): readonly Correspondence[] =>
  picture.correspondences.flatMap((each) => {
    const at = project(picture, each.pointInWorldM);
    return at === null ? [] : [{ ...each, ...at }];
  });

// At depth 1.
const rayInCamera = (camera: Pinhole, { xPx, yPx }: PixelPoint): Vector3 => ({
  x: (xPx - camera.cxPx) / camera.fxPx,
  y: (yPx - camera.cyPx) / camera.fyPx,
  z: 1,
});

function depthOfPoints(picture: LocatedPicture, at: PixelPoint):
    number | null {
  const { camera, worldFromCamera, correspondences } = picture;
  const cameraFromWorld = inverse(worldFromCamera);
  const nearPx = NEAR_SHARE * Math.max(camera.widthPx, camera.heightPx);
  const depths = correspondences
      .filter(({ inlier }) => inlier)
      .map(({ xPx, yPx, pointInWorldM }) => ({
        awayPx: Math.hypot(xPx - at.xPx, yPx - at.yPx),
        depthM: transformPoint(cameraFromWorld, pointInWorldM).z,
      }))
      .filter(({ awayPx, depthM }) => awayPx <= nearPx && depthM > 0)
      .sort((a, b) => a.awayPx - b.awayPx)
      .slice(0, NEIGHBOURS)
      .map(({ depthM }) => depthM)
      .sort((a, b) => a - b);
  return depths.length < NEIGHBOURS ? null : depths[1]!;
}

function depthOfFloor(picture: LocatedPicture, ray: Vector3, bounds: Bounds,
    up: UpAxis): number | null {
  const axis = axisOf(up);
  const { rotation, translationM } = picture.worldFromCamera;
  const along = rotate(rotation, ray)[axis];
  const depthM = (floorM(bounds, up) - translationM[axis]) / along;
  return depthM > 0 && depthM <= MAX_FLOOR_DISTANCE_M ? depthM : null;
}

/**
 * The point that the picture shows there: at the depth of the points that were
 * recognised around it, else on the floor; null: neither is there.
 */
export function pinAt(picture: LocatedPicture, at: PixelPoint,
    bounds: Bounds | null, up: UpAxis): Pin | null {
  const ray = rayInCamera(picture.camera, at);
  const onPoints = depthOfPoints(picture, at);
  const depthM = onPoints ??
      (bounds === null ? null : depthOfFloor(picture, ray, bounds, up));
  if (depthM === null) return null;
  return {
    pointInWorldM: transformPoint(picture.worldFromCamera,
        { x: ray.x * depthM, y: ray.y * depthM, z: depthM }),
    from: onPoints === null ? 'floor' : 'points',
  };
}
