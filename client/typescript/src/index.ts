// @treeline/client: where is this camera?

export * from './camera/arcore.js';
export * from './camera/arkit.js';
export { cropped, gravityInCamera, pinhole, pinholeOf, resized, type Camera,
  type CameraModel, type Pinhole } from './camera/camera.js';
export * from './camera/colmap.js';
export * from './camera/opencv.js';
export * from './camera/opengl_axes.js';
export * from './camera/webxr.js';
export { TreelineError, type ErrorCode } from './client/error.js';
export { fromGeoPoseAxes, toBasicQuaternion, toBasicYpr, type BasicQuaternion,
  type BasicYpr, type GeoPoseAnswer, type GeoPoseQuery, type GeoPosition } from
  './client/geo_pose.js';
export { FrameQueue, type LatestOptions, type TimedAnswer, type TimedQuery }
  from './client/localize_latest.js';
export type { MakeSocket, Socket } from './client/localize_stream.js';
export type { RetryPolicy, Tools } from './client/retry.js';
export { fixOf, TreelineClient, type CallOptions, type ClientOptions,
  type Fetch, type ServerHealth } from './client/treeline_client.js';
export { newTraceparent } from './client/traceparent.js';
export type * from './client/types.js';
export { DriftCorrector, type DriftEstimate, type DriftState, type Fix,
  type FixVerdict } from './fusion/drift_corrector.js';
export { DEFAULT_PARAMETERS, type DriftParameters } from
  './fusion/parameters.js';
export { compose, fromColumnMajor4, IDENTITY, interpolate, inverse,
  toColumnMajor4, transformPoint, type RigidTransform } from
  './geometry/rigid_transform.js';
export { angleBetweenRad, fromAxisAngle, IDENTITY_ROTATION, rotate,
  toAxisAngle, type Quaternion } from './geometry/rotation.js';
export type { Vector3 } from './geometry/vector3.js';
