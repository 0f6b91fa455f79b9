// What is asked, and what is answered.

import type { Camera } from '../camera/camera.js';
import type { RigidTransform } from '../geometry/rigid_transform.js';
import type { Vector3 } from '../geometry/vector3.js';

/** Colour without encoding: R, G, B interleaved, rows from the top. */
export interface RgbImage {
  readonly widthPx: number;
  readonly heightPx: number;
  readonly data: Uint8Array;
}

/** Depth along the optical axis, little-endian, rows from the top. 0 and 65535
 * mean "not measured". */
export interface DepthImage {
  readonly widthPx: number;
  readonly heightPx: number;
  readonly data: Uint16Array;
}

/**
 * `registered_to_color`: a depth pixel sees what the colour pixel at its place
 * sees. `scene_calibration`: straight from the depth camera that the scene was
 * recorded with. A camera: straight from that one.
 */
export type DepthRegistration = 'registered_to_color' | 'scene_calibration' |
  { readonly camera: Camera; readonly colorFromDepth: RigidTransform };

export interface Depth {
  /** A 16-bit PNG, or raw values. */
  readonly image: Uint8Array | Blob | DepthImage;
  /** Metres per unit of a value: 0.001 for millimetres. */
  readonly unitM: number;
  readonly registration: DepthRegistration;
  /** World units per measured metre; refused with `scene_calibration`. */
  readonly depthScale?: number;
}

export interface PosePrior {
  /** Of the scene's pose sensor. */
  readonly worldFromCamera: RigidTransform;
  readonly positionRadiusM: number;
  readonly rotationRadiusRad: number;
}

export interface PositionPrior {
  readonly positionInWorldM: Vector3;
  readonly radiusM: number;
}

export interface HeightBand {
  /** Absent: the world's z axis. */
  readonly upInWorld?: Vector3;
  readonly minM: number;
  readonly maxM: number;
}

/** Which side of the picture, as it is sent, is up in the world. */
export type SideUp = 'top' | 'right' | 'bottom' | 'left';

export interface LocalizeQuery {
  /** Absent: the server finds out, among candidateScenes or all. */
  readonly scene?: string;
  readonly candidateScenes?: readonly string[];
  /** Absent: the newest that is ready. */
  readonly modelVersion?: string;
  /** A JPEG or PNG file, or raw pixels. */
  readonly color: Uint8Array | Blob | RgbImage;
  /** The camera that took `color`. Absent: the scene's. */
  readonly camera?: Camera;
  readonly depth?: Depth;
  readonly sideUp?: SideUp;
  /** sideUp counts for no more than EXIF's. */
  readonly sideUpIsGuess?: boolean;
  /** Where things fall, in the camera's frame: see gravityInCamera(). */
  readonly gravityInCameraMps2?: Vector3;
  /** The same seed, picture and model version give the same answer. */
  readonly seed?: bigint;
  /** Most that the server may take, beside the call's own deadline. */
  readonly timeBudgetMs?: number;
  /** In [0, 1]. Absent: the scene's own threshold. */
  readonly minConfidence?: number;
  readonly prior?: PosePrior;
  readonly positionPrior?: PositionPrior;
  readonly heightBand?: HeightBand;
  /** Whether the answer says which pixels support it. */
  readonly wantsCorrespondences?: boolean;
}

export interface Correspondence {
  /** The centre of the top left pixel is (0, 0). */
  readonly xPx: number;
  readonly yPx: number;
  readonly pointInCameraM: Vector3;
  readonly pointInWorldM: Vector3;
  readonly inlier: boolean;
}

/** A scene that the server considered, if it was to choose one. */
export interface SceneCandidate {
  readonly scene: string;
  /** In [0, 1], comparable within one answer only. */
  readonly similarity: number;
  /** Whether a pose in it was looked for; the rest is of that. */
  readonly tried: boolean;
  readonly localized: boolean;
  readonly confidence: number;
  readonly inliers: number;
}

/** Where the server's time went, in the order of its stages. */
export interface ServerTimings {
  readonly queueMs: number;
  readonly decodeMs: number;
  readonly sampleMs: number;
  readonly forestMs: number;
  readonly poseMs: number;
  readonly localizeMs: number;
  readonly totalMs: number;
}

/** What both kinds of answer carry. */
export interface Evidence {
  readonly inliers: number;
  readonly samples: number;
  /** In [0, 1]. */
  readonly inlierRatio: number;
  /** Probability that the pose is right, within 5 cm and 5 degrees. */
  readonly confidence: number;
  /** Of answers that reach it, 99 of 100 were right in training. */
  readonly confidenceThreshold: number;
  /**
   * The pose is of a camera whose focal length is so many times the stated one,
   * since that fits better; 1: the stated one fits.
   */
  readonly focalScale: number;
  /**
   * If localized by a picture of which no camera was stated, or a guess that
   * does not fit: the camera that the pose is of, found by what is seen. null:
   * the stated one, or the scene's.
   */
  readonly camera: Camera | null;
  /** Who answered. */
  readonly scene: string;
  readonly modelVersion: string;
  /** The best first; empty if the query named its scene. */
  readonly candidates: readonly SceneCandidate[];
  readonly correspondences: readonly Correspondence[];
  readonly timings: ServerTimings;
  /** From the call to the answer, retries included. */
  readonly roundTripMs: number;
}

export interface Localized extends Evidence {
  readonly localized: true;
  /**
   * Maps points of the camera's frame (x right, y down, z forward of the
   * picture as it was sent) into the scene's world. Of the camera that
   * poseSensor says.
   */
  readonly worldFromCamera: RigidTransform;
  /** Row-major 6x6: x, y, z (m), rotation about x, y, z (rad), in the world. */
  readonly covariance: readonly number[];
  /** The camera of the pair that the training poses were of. */
  readonly poseSensor: 'color' | 'depth';
}

export interface NotLocalized extends Evidence {
  readonly localized: false;
  /** TOO_FEW_SAMPLES, TOO_FEW_INLIERS, POORLY_CONSTRAINED, LOW_CONFIDENCE,
   * CONTRADICTS_PRIOR, CONTRADICTS_DEPTH or UNKNOWN_CAMERA. */
  readonly reason: string;
}

/** "Not localized" is an answer like any other. */
export type LocalizeAnswer = Localized | NotLocalized;

export interface Scene {
  readonly name: string;
  readonly state: 'unloaded' | 'loading' | 'ready' | 'failed' | 'unknown';
  /** Why it failed: "DATA_LOSS: ..."; empty otherwise. */
  readonly failure: string;
  /** The version that answers; empty if none does. */
  readonly modelVersion: string;
  /** All versions, the newest first. */
  readonly versions: readonly string[];
  readonly displayName: string;
  /** Of the version that answers: how it was learnt. Null: none answers. */
  readonly method: string | null;
  /** The camera of queries that bring none. Null: none answers. */
  readonly camera: Camera | null;
  /** Box of the training points. Null: none answers. */
  readonly boundsInWorldM: { readonly min: Vector3; readonly max: Vector3 } |
    null;
  /** Where its world lies on the Earth. Null: nobody said. */
  readonly geoAnchor: GeoAnchor | null;
}

/** The world's origin lies there; enuFromWorld turns its axes into East, North,
 * Up. */
export interface GeoAnchor {
  readonly latitudeDeg: number;
  readonly longitudeDeg: number;
  /** Above the WGS84 ellipsoid. */
  readonly heightM: number;
  readonly enuFromWorld: RigidTransform['rotation'];
}

export interface SceneMapOptions {
  /** At most so many points, up to 200000. Default: 50000. */
  readonly maxPoints?: number;
  /** The first who asks for it waits until it is computed. */
  readonly wantsCoverage?: boolean;
}

/** What a scene's model knows of it: for pictures. */
export interface SceneMap {
  readonly scene: string;
  readonly modelVersion: string;
  /** x, y and z of each point. */
  readonly pointsInWorldM: Float32Array;
  /** Of each point. */
  readonly brightness: Uint8Array;
  readonly pointsInModel: number;
  /** Where the keyframes were taken, in the order of the training frames. */
  readonly worldFromKeyframe: readonly RigidTransform[];
  /** That took them. Null: a newer server's. */
  readonly camera: Camera | null;
  /** Into a plan whose z is up. */
  readonly planFromWorld: RigidTransform['rotation'];
  /** Null: it was not asked for. */
  readonly coverage: SceneCoverage | null;
}

/** Where queries will be answered. Coordinates are the plan's. */
export interface SceneCoverage {
  readonly minXM: number;
  readonly minYM: number;
  readonly cellM: number;
  readonly columns: number;
  readonly rows: number;
  readonly headings: number;
  /** z of the cameras, and of the lowest surfaces. */
  readonly heightM: number;
  readonly groundM: number;
  /** Of place (column, row) at row * columns + column: 1: a camera may well be
   * there. */
  readonly isOpen: Uint8Array;
  /** Of how many headings queries will be answered, and perhaps. */
  readonly goodHeadings: Uint8Array;
  readonly weakHeadings: Uint8Array;
  readonly openM2: number;
  readonly goodShare: number;
  readonly weakShare: number;
}

/** What became of a query that somebody made. */
export interface RecentQuery {
  readonly timeUtc: string;
  /** Null: it was not localized. */
  readonly worldFromCamera: RigidTransform | null;
  /** Why not; empty: it was. */
  readonly reason: string;
  readonly isError: boolean;
  readonly confidence: number;
  readonly inliers: number;
  readonly samples: number;
  readonly totalMs: number;
}
