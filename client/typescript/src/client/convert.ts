// Queries to messages, messages to answers.

import { create, type MessageInitShape } from '@bufbuild/protobuf';

import type { Camera, CameraModel } from '../camera/camera.js';
import { RgbdSensor, type Camera as CameraMessage } from
  '../gen/treeline/v1/camera_pb.js';
import { DepthRegistration as Registration, Orientation,
  type DepthImageSchema, type FrameSchema } from
  '../gen/treeline/v1/frame_pb.js';
import type { GeoAnchor as GeoAnchorMessage, Pose,
  Quaternion as QuaternionMessage, Vector3 as VectorMessage } from
  '../gen/treeline/v1/geometry_pb.js';
import { LocalizeRequestSchema, NotLocalizedReason, Outcome,
  type LocalizeRequest, type LocalizeResponse,
  type SceneCandidate as CandidateMessage } from
  '../gen/treeline/v1/relocalization_pb.js';
import { SceneState, type GetSceneMapResponse, type RecentQuery as
  QueryMessage, type SceneCoverage as CoverageMessage, type SceneInfo } from
  '../gen/treeline/v1/scenes_pb.js';
import { IDENTITY_ROTATION, type Quaternion } from '../geometry/rotation.js';
import type { RigidTransform } from '../geometry/rigid_transform.js';
import { ZERO, type Vector3 } from '../geometry/vector3.js';
import { TreelineError } from './error.js';
import type { Depth, Evidence, GeoAnchor, LocalizeAnswer, LocalizeQuery,
  RecentQuery, RgbImage, Scene, SceneCandidate, SceneCoverage, SceneMap, SideUp }
  from './types.js';

const ORIENTATION: Readonly<Record<SideUp, Orientation>> = {
  top: Orientation.TOP_UP,
  right: Orientation.RIGHT_UP,
  bottom: Orientation.BOTTOM_UP,
  left: Orientation.LEFT_UP,
};

const cameraMessage = ({ model, widthPx, heightPx, parameters }: Camera) =>
  ({ model, widthPx, heightPx, parameters: [...parameters] });

const bytesOf = async (file: Uint8Array | Blob): Promise<Uint8Array> =>
  file instanceof Uint8Array ? file : new Uint8Array(await file.arrayBuffer());

const isFile = (image: object): image is Uint8Array | Blob =>
  image instanceof Uint8Array || image instanceof Blob;

async function colorMessage(color: Uint8Array | Blob | RgbImage) {
  return isFile(color) ?
    { data: { case: 'encoded' as const, value: await bytesOf(color) } } :
    { data: { case: 'rgb8' as const, value: { widthPx: color.widthPx,
      heightPx: color.heightPx, data: color.data } } };
}

// Little-endian, whatever this machine is.
function littleEndian(values: Uint16Array): Uint8Array {
  const view = new DataView(new ArrayBuffer(values.length * 2));
  values.forEach((value, i) => view.setUint16(2 * i, value, true));
  return new Uint8Array(view.buffer);
}

async function depthMessage(depth: Depth):
    Promise<MessageInitShape<typeof DepthImageSchema>> {
  const { image, registration } = depth;
  const data = isFile(image) ?
    { case: 'png' as const, value: await bytesOf(image) } :
    { case: 'raw' as const, value: { widthPx: image.widthPx,
      heightPx: image.heightPx, data: littleEndian(image.data) } };
  return {
    data,
    unitM: depth.unitM,
    registration: registration === 'registered_to_color' ?
      Registration.REGISTERED_TO_COLOR :
      registration === 'scene_calibration' ?
        Registration.SCENE_CALIBRATION : Registration.EXPLICIT,
    ...typeof registration === 'object' && { calibration: {
      depthCamera: cameraMessage(registration.camera),
      colorFromDepth: registration.colorFromDepth,
    } },
    ...depth.depthScale !== undefined && { depthScale: depth.depthScale },
  };
}

async function frameMessage(query: LocalizeQuery):
    Promise<MessageInitShape<typeof FrameSchema>> {
  return {
    color: await colorMessage(query.color),
    ...query.camera && { camera: cameraMessage(query.camera) },
    ...query.depth && { depth: await depthMessage(query.depth) },
    ...query.sideUp && { orientation: ORIENTATION[query.sideUp] },
    orientationIsGuess: query.sideUpIsGuess ?? false,
    ...query.gravityInCameraMps2 &&
        { gravityInCameraMps2: query.gravityInCameraMps2 },
  };
}

export async function requestOf(query: LocalizeQuery):
    Promise<LocalizeRequest> {
  return create(LocalizeRequestSchema, {
    scene: query.scene ?? '',
    candidateScenes: [...query.candidateScenes ?? []],
    modelVersion: query.modelVersion ?? '',
    frame: await frameMessage(query),
    options: {
      includeCorrespondences: query.wantsCorrespondences ?? false,
      ...query.seed !== undefined && { seed: query.seed },
      ...query.timeBudgetMs !== undefined &&
          { timeBudgetMs: query.timeBudgetMs },
      ...query.minConfidence !== undefined &&
          { minConfidence: query.minConfidence },
      ...query.prior && { prior: query.prior },
      ...query.positionPrior && { positionPrior: query.positionPrior },
      ...query.heightBand && { heightBand: query.heightBand },
    },
  });
}

const vectorOf = (v: VectorMessage | undefined): Vector3 =>
  v === undefined ? ZERO : { x: v.x, y: v.y, z: v.z };

const quaternionOf = ({ w, x, y, z }: QuaternionMessage): Quaternion =>
  ({ w, x, y, z });

// Never a pose that was not said; bit for bit what the server computed.
function transformOf(pose: Pose | undefined): RigidTransform {
  if (pose?.rotation === undefined) {
    throw new TreelineError('internal', 'the server sent a pose without one');
  }
  return { rotation: quaternionOf(pose.rotation),
    translationM: vectorOf(pose.translationM) };
}

const candidateOf = (c: CandidateMessage): SceneCandidate => ({
  scene: c.scene,
  similarity: c.similarity,
  tried: c.tried,
  localized: c.outcome === Outcome.LOCALIZED,
  confidence: c.confidence,
  inliers: c.inliers,
});

const evidenceOf = (
    r: LocalizeResponse, roundTripMs: number): Evidence => ({
  inliers: r.inliers,
  samples: r.samples,
  inlierRatio: r.inlierRatio,
  confidence: r.confidence,
  confidenceThreshold: r.confidenceThreshold,
  focalScale: r.focalScale ?? 1,
  camera: cameraOf(r.camera),
  scene: r.scene,
  modelVersion: r.modelVersion,
  candidates: r.candidates.map(candidateOf),
  correspondences: r.correspondences.map((c) => ({
    xPx: c.colorPixel?.xPx ?? 0,
    yPx: c.colorPixel?.yPx ?? 0,
    pointInCameraM: vectorOf(c.pointInCameraM),
    pointInWorldM: vectorOf(c.pointInWorldM),
    inlier: c.inlier,
  })),
  timings: {
    queueMs: r.timings?.queueMs ?? 0,
    decodeMs: r.timings?.decodeMs ?? 0,
    sampleMs: r.timings?.sampleMs ?? 0,
    forestMs: r.timings?.forestMs ?? 0,
    poseMs: r.timings?.poseMs ?? 0,
    localizeMs: r.timings?.localizeMs ?? 0,
    totalMs: r.timings?.totalMs ?? 0,
  },
  roundTripMs,
});

export function answerOf(
    r: LocalizeResponse, roundTripMs: number): LocalizeAnswer {
  const evidence = evidenceOf(r, roundTripMs);
  switch (r.outcome) {
    case Outcome.LOCALIZED:
      if (r.covariance.length !== 36) {
        throw new TreelineError('internal',
            `the server sent ${r.covariance.length} covariances`);
      }
      return {
        ...evidence,
        localized: true,
        worldFromCamera: transformOf(r.worldFromCamera),
        covariance: r.covariance,
        poseSensor: r.poseSensor === RgbdSensor.DEPTH ? 'depth' : 'color',
      };
    case Outcome.NOT_LOCALIZED:
      return {
        ...evidence,
        localized: false,
        // A newer server may have reasons that have no name here.
        reason: NotLocalizedReason[r.reason] ?? `REASON_${r.reason}`,
      };
    default:
      throw new TreelineError('internal', 'the server sent no outcome');
  }
}

const cameraOf = (c: CameraMessage | undefined): Camera | null =>
  c === undefined ? null : {
    // A newer server may have models that have no name here.
    model: c.model as CameraModel,
    widthPx: c.widthPx,
    heightPx: c.heightPx,
    parameters: c.parameters,
  };

const anchorOf = (a: GeoAnchorMessage | undefined): GeoAnchor | null =>
  a === undefined ? null : {
    latitudeDeg: a.latitudeDeg,
    longitudeDeg: a.longitudeDeg,
    heightM: a.heightM,
    enuFromWorld: a.enuFromWorld === undefined ? IDENTITY_ROTATION :
      quaternionOf(a.enuFromWorld),
  };

const STATE: Readonly<Record<SceneState, Scene['state']>> = {
  [SceneState.UNSPECIFIED]: 'unknown',
  [SceneState.UNLOADED]: 'unloaded',
  [SceneState.LOADING]: 'loading',
  [SceneState.READY]: 'ready',
  [SceneState.FAILED]: 'failed',
};

export const sceneOf = (s: SceneInfo): Scene => ({
  name: s.scene,
  state: STATE[s.state] ?? 'unknown',
  failure: s.failure === undefined ? '' :
    `${s.failure.code}: ${s.failure.message}`,
  modelVersion: s.modelVersion,
  versions: s.versions.map(({ version }) => version),
  displayName: s.displayName,
  method: s.model?.method ?? null,
  camera: cameraOf(s.defaultCamera ?? s.model?.calibration?.color),
  boundsInWorldM: s.model?.boundsMinInWorldM === undefined ? null : {
    min: vectorOf(s.model.boundsMinInWorldM),
    max: vectorOf(s.model.boundsMaxInWorldM),
  },
  geoAnchor: anchorOf(s.geoAnchor),
});

// Little-endian, whatever this machine is.
function floatsOf(bytes: Uint8Array): Float32Array {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  return Float32Array.from({ length: bytes.length >> 2 },
      (_, i) => view.getFloat32(4 * i, true));
}

function coverageOf(c: CoverageMessage | undefined): SceneCoverage | null {
  if (c === undefined) return null;
  const { columns, rows, isOpen, goodHeadings, weakHeadings } = c;
  for (const of of [isOpen, goodHeadings, weakHeadings]) {
    if (of.length !== columns * rows) {
      throw new TreelineError('internal',
          `the server sent ${of.length} of ${columns} x ${rows} places`);
    }
  }
  return { minXM: c.minXM, minYM: c.minYM, cellM: c.cellM, columns, rows,
    headings: c.headings, heightM: c.heightM, groundM: c.groundM, isOpen,
    goodHeadings, weakHeadings, openM2: c.openM2, goodShare: c.goodShare,
    weakShare: c.weakShare };
}

export function sceneMapOf(m: GetSceneMapResponse): SceneMap {
  const pointsInWorldM = floatsOf(m.pointsInWorldM);
  if (pointsInWorldM.length !== 3 * m.brightness.length) {
    throw new TreelineError('internal', 'the server sent points without ' +
        'brightness');
  }
  return {
    scene: m.scene,
    modelVersion: m.modelVersion,
    pointsInWorldM,
    brightness: m.brightness,
    pointsInModel: Number(m.pointsInModel),
    worldFromKeyframe: m.worldFromKeyframe.map(transformOf),
    camera: cameraOf(m.camera),
    planFromWorld: m.planFromWorld === undefined ? IDENTITY_ROTATION :
      quaternionOf(m.planFromWorld),
    coverage: coverageOf(m.coverage),
  };
}

export const recentQueryOf = (q: QueryMessage): RecentQuery => ({
  timeUtc: q.timeUtc,
  worldFromCamera: q.worldFromCamera === undefined ? null :
    transformOf(q.worldFromCamera),
  reason: q.reason,
  isError: q.isError,
  confidence: q.confidence,
  inliers: q.inliers,
  samples: q.samples,
  totalMs: q.totalMs,
});
