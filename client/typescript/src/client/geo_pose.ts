// The GeoPose Protocol, version 2, as treeline-server speaks it at /geopose:
// docs/reference/http.md.

import { colmapParameters } from '../camera/colmap.js';
import type { Camera } from '../camera/camera.js';
import { conjugate, multiply, normalized, rotate, type Quaternion } from
  '../geometry/rotation.js';
import { TreelineError, type ErrorCode } from './error.js';

export interface GeoPoseQuery {
  readonly captureTimeMs: number;
  /** A JPEG or PNG file, and its size. */
  readonly color: Uint8Array | Blob;
  readonly widthPx: number;
  readonly heightPx: number;
  /** With Treeline's pixels; half a pixel is added for the protocol. Absent:
   * the scene's camera. */
  readonly camera?: Camera;
  /** Degrees clockwise by which the picture is to be turned to be upright. */
  readonly turnClockwiseDeg?: 0 | 90 | 180 | 270;
  /** About where it was taken. */
  readonly geolocation?: {
    readonly latitudeDeg: number;
    readonly longitudeDeg: number;
    readonly altitudeM: number;
    readonly accuracyM: number;
  };
}

/** Where the camera was on the Earth; toBasicQuaternion() writes it anew. */
export interface GeoPoseAnswer {
  readonly captureTimeMs: number;
  readonly latitudeDeg: number;
  readonly longitudeDeg: number;
  /** Above the WGS84 ellipsoid, not above the sea. */
  readonly heightM: number;
  /**
   * Turns the camera's axes (x right, y down, z forward) into East, North, Up
   * at the camera. The protocol's own quaternion is that of x right, y forward,
   * z up: fromGeoPoseAxes().
   */
  readonly enuFromCamera: Quaternion;
  /** 95 of 100 are within it. */
  readonly positionAccuracyM: number;
  readonly orientationAccuracyDeg: number;
}

// x right, y forward, z up from x right, y down, z forward: a quarter turn
// about x.
const GEO_POSE_FROM_CAMERA: Quaternion =
    { w: Math.SQRT1_2, x: -Math.SQRT1_2, y: 0, z: 0 };

export interface GeoPosition {
  readonly lat: number;
  readonly lon: number;
  readonly h: number;
}

/** OGC GeoPose 1.0, Basic-Quaternion, as the standard writes it in JSON. */
export interface BasicQuaternion {
  readonly position: GeoPosition;
  readonly quaternion: Quaternion;
}

/** OGC GeoPose 1.0, Basic-YPR, as the standard writes it in JSON (degrees). */
export interface BasicYpr {
  readonly position: GeoPosition;
  readonly angles: { readonly yaw: number, readonly pitch: number,
    readonly roll: number };
}

const positionOf = ({ latitudeDeg, longitudeDeg, heightM }: GeoPoseAnswer):
    GeoPosition => ({ lat: latitudeDeg, lon: longitudeDeg, h: heightM });

// Of the device's axes: x right, y forward, z up.
const enuFromDevice = ({ enuFromCamera }: GeoPoseAnswer): Quaternion =>
  normalized(multiply(enuFromCamera, conjugate(GEO_POSE_FROM_CAMERA)));

/** What other programs that know GeoPose read. */
export function toBasicQuaternion(answer: GeoPoseAnswer): BasicQuaternion {
  const { x, y, z, w } = enuFromDevice(answer);
  return { position: positionOf(answer), quaternion: { x, y, z, w } };
}

/**
 * The same with angles: about the device's z (up), then its new y (forward),
 * then its new x (right), anticlockwise seen from the axis' end. Where the
 * picture's right side points straight up or down, yaw and roll are one; then
 * roll is 0.
 */
export function toBasicYpr(answer: GeoPoseAnswer): BasicYpr {
  const { w, x, y, z } = enuFromDevice(answer);
  // The device's x axis in East, North, Up.
  const right = rotate({ w, x, y, z }, { x: 1, y: 0, z: 0 });
  const level = Math.hypot(right.x, right.y);
  const isOne = level < 1e-9;
  const yaw = isOne ? 2 * Math.atan2(z, w) : Math.atan2(right.y, right.x);
  const roll = isOne ? 0 :
    Math.atan2(2 * (y * z + w * x), 1 - 2 * (x * x + y * y));
  const degrees = (rad: number) => rad * 180 / Math.PI;
  return { position: positionOf(answer), angles: { yaw: degrees(yaw),
    pitch: degrees(Math.atan2(-right.z, level)), roll: degrees(roll) } };
}

/** enuFromCamera of the quaternion of a GeoPose. */
export const fromGeoPoseAxes = (quaternion: Quaternion): Quaternion =>
  normalized(multiply(quaternion, GEO_POSE_FROM_CAMERA));

// In pieces: a spread of millions of arguments is too much for engines.
function base64Of(bytes: Uint8Array): string {
  const parts: string[] = [];
  for (let at = 0; at < bytes.length; at += 0x8000) {
    parts.push(String.fromCharCode(...bytes.subarray(at, at + 0x8000)));
  }
  return btoa(parts.join(''));
}

const PRIVACY = { dataRetention: [], dataAcceptableUse: [],
  dataSanitizationApplied: [], dataSanitizationRequested: [] };

export async function geoPoseRequestOf(query: GeoPoseQuery): Promise<object> {
  const bytes = query.color instanceof Uint8Array ? query.color :
    new Uint8Array(await query.color.arrayBuffer());
  const timestamp = Math.round(query.captureTimeMs);
  const { camera, geolocation, turnClockwiseDeg = 0 } = query;
  return {
    id: `${timestamp}`,
    timestamp,
    type: 'geopose',
    sensors: [{ id: 'camera', type: 'camera' },
      ...geolocation ? [{ id: 'place', type: 'geolocation' }] : []],
    sensorReadings: {
      cameraReadings: [{
        timestamp,
        sensorId: 'camera',
        privacy: PRIVACY,
        sequenceNumber: 0,
        imageFormat: 'JPG',
        size: [query.widthPx, query.heightPx],
        imageBytes: base64Of(bytes),
        imageOrientation: { mirrored: false, rotation: turnClockwiseDeg },
        ...camera && { params: { model: camera.model,
          modelParams: colmapParameters(camera) } },
      }],
      ...geolocation && { geolocationReadings: [{
        timestamp,
        sensorId: 'place',
        privacy: PRIVACY,
        latitude: geolocation.latitudeDeg,
        longitude: geolocation.longitudeDeg,
        altitude: geolocation.altitudeM,
        accuracy: geolocation.accuracyM,
        altitudeAccuracy: geolocation.accuracyM,
        heading: 0,
        speed: 0,
      }] },
    },
  };
}

function numberAt(json: unknown, ...path: string[]): number {
  let value = json;
  for (const name of path) {
    value = (value as Record<string, unknown> | undefined)?.[name];
  }
  if (typeof value !== 'number' || !Number.isFinite(value)) {
    throw new TreelineError(
        'internal', `the server's GeoPose has no ${path.join('.')}`);
  }
  return value;
}

export function geoPoseAnswerOf(json: unknown): GeoPoseAnswer {
  const q = (name: string) => numberAt(json, 'geopose', 'quaternion', name);
  return {
    captureTimeMs: numberAt(json, 'timestamp'),
    latitudeDeg: numberAt(json, 'geopose', 'position', 'lat'),
    longitudeDeg: numberAt(json, 'geopose', 'position', 'lon'),
    heightM: numberAt(json, 'geopose', 'position', 'h'),
    enuFromCamera: fromGeoPoseAxes(
        { w: q('w'), x: q('x'), y: q('y'), z: q('z') }),
    positionAccuracyM: numberAt(json, 'accuracy', 'position'),
    orientationAccuracyDeg: numberAt(json, 'accuracy', 'orientation'),
  };
}

// Codes of answers that are not the server's own, as of a proxy.
const CODE_OF_STATUS: Readonly<Record<number, ErrorCode>> = {
  400: 'internal', 401: 'unauthenticated', 403: 'permission_denied',
  404: 'unimplemented', 429: 'unavailable', 502: 'unavailable',
  503: 'unavailable', 504: 'unavailable',
};

interface ErrorBody {
  readonly code?: unknown;
  readonly message?: unknown;
  readonly details?: readonly { readonly type?: unknown, readonly debug?: {
    readonly reason?: string, readonly metadata?: Record<string, string>,
    readonly retryDelay?: string } }[];
}

/** The error of a response that is none: the body is that of Connect. */
export async function geoPoseErrorOf(response: Response):
    Promise<TreelineError> {
  const seconds = response.headers.get('Retry-After');
  let retryAfterMs = seconds !== null && /^\d+$/.test(seconds) ?
    Number(seconds) * 1000 : null;
  let body: ErrorBody | null = null;
  try {
    body = await response.json() as ErrorBody | null;
  } catch {
    // Not JSON: the status alone tells.
  }
  if (typeof body?.code !== 'string') {
    return new TreelineError(CODE_OF_STATUS[response.status] ?? 'unknown',
        `the server answered with status ${response.status}`, '', {},
        retryAfterMs);
  }
  const debugOf = (type: string) => body?.details?.find(
      (detail) => detail.type === type)?.debug;
  const info = debugOf('google.rpc.ErrorInfo');
  const delay = debugOf('google.rpc.RetryInfo')?.retryDelay;
  if (delay !== undefined) retryAfterMs = parseFloat(delay) * 1000;
  return new TreelineError(body.code as ErrorCode, String(body.message),
      info?.reason ?? '', info?.metadata ?? {}, retryAfterMs);
}
