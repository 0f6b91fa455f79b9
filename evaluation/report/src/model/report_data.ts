// What a report is made of: the JSON of treeline evaluate (docs/reference/evaluation.md)
// with what the page needs beside it, and that of treeline recognize. Lengths
// in metres, angles in degrees, shares in [0, 1]; null: nothing to say.

export type Maybe = number | null;

export interface Percentiles {
  p50: Maybe;
  p95: Maybe;
  p99: Maybe;
}

export interface Headline {
  frames: number;
  scored: number;
  localized: number;
  errors: number;
  correct_5cm_5deg: Maybe;
  correct_2cm_2deg: Maybe;
  median_translation_m: Maybe;
  median_rotation_deg: Maybe;
  latency_ms: Percentiles;
  cpu_ms: Percentiles;
}

// A rotation as a unit quaternion, and a translation (m).
export interface Pose {
  qw: number;
  qx: number;
  qy: number;
  qz: number;
  tx: number;
  ty: number;
  tz: number;
}

export type Point = [number, number, number];

export interface Stages {
  sample_ms: Maybe;
  forest_ms: Maybe;
  pose_ms: Maybe;
  // Parts of pose_ms.
  features_ms: Maybe;
  verify_ms: Maybe;
}

export interface Frame {
  stem: string;
  outcome: 'LOCALIZED' | 'NOT_LOCALIZED' | 'ERROR';
  reason: string | null;
  inliers: Maybe;
  samples: Maybe;
  inlier_ratio: Maybe;
  confidence: Maybe;
  world_from_camera: Pose | null;
  true_world_from_camera: Pose | null;
  translation_error_m: Maybe;
  rotation_error_deg: Maybe;
  // The best pose of a frame that was not localized.
  refused: {
    world_from_camera: Pose;
    translation_error_m: Maybe;
    rotation_error_deg: Maybe;
  } | null;
  latency_ms: Maybe;
  cpu_ms: Maybe;
  decode_ms: Maybe;
  stages: Stages | null;
  // To the nearest camera of the training set; combined_m counts a turn by one
  // radian as 1.5 m.
  training_distance:
      { translation_m: number; rotation_deg: number; combined_m: number } | null;
}

export interface Threshold {
  name: string;
  correct: Maybe;
}

export interface ReliabilityBin {
  low: number;
  high: number;
  frames: number;
  confidence: Maybe;
  correct: Maybe;
}

export interface Confidence {
  stated: boolean;
  threshold: number;
  precision: Maybe;
  recall: Maybe;
  expected_calibration_error: Maybe;
  bins: ReliabilityBin[];
}

export interface ForeignTally {
  source: string;
  with_depth: boolean;
  images: number;
  accepted: number;
  refused: number;
  unreadable: number;
  accepted_names: string[];
  problems: string[];
}

// What a group of frames shows. found: right poses, answered or refused;
// wrong, gross: of the answers that would be relied on.
export interface AnswerCounts {
  frames: number;
  answered: number;
  right: number;
  found: number;
  relied_on: number;
  wrong: number;
  gross: number;
  share_right: Maybe;
  share_answered: Maybe;
  share_found: Maybe;
  coverage: Maybe;
  precision: Maybe;
  calibration_error: Maybe;
  latency_ms: Percentiles;
}

// The frames changed; the first row of a method has them as they are.
export interface Perturbed extends AnswerCounts {
  name: string;
  is_foreign: boolean;
}

// Frames with low <= measure < high; null: no end.
export interface TrainingDistanceBin extends AnswerCounts {
  low: number;
  high: Maybe;
}

// By the distance and the angle to the nearest training camera, and by how far
// beyond 0.3 m or 15 degrees the frame is of every one: the larger of both
// shares.
export interface TrainingDistanceBins {
  by_distance_m: TrainingDistanceBin[];
  by_angle_deg: TrainingDistanceBin[];
  by_view_gap: TrainingDistanceBin[];
}

// The frames of one of several cameras.
export interface CameraRow extends AnswerCounts {
  camera: string;
}

// A frame's photograph with pixels: x, y, x, y, ... in the frame's size.
export interface Picture {
  frame: number;
  kind: 'worst' | 'median' | 'best';
  width: number;
  height: number;
  photo: string;
  inliers: number[];
  outliers: number[];
  error_direction: 'depth' | 'sideways' | null;
  claimed_deviation_m: Maybe;
}

export interface HeatMap {
  stem: string;
  width: number;
  height: number;
  photo: string;
  map: string;
  predictions: number;
  median_error_m: number;
}

export interface LevelSplits {
  splits: number;
  by_left_share: number[];
}

// Unit vectors in the world: right x forward = up.
export interface Axes {
  right: Point;
  forward: Point;
  up: Point;
}

export interface ModelSection {
  title: string;
  rows: [string, string][];
}

export interface MethodPage {
  inputs: { training: string; query: string } | null;
  model_description: ModelSection[];
  axes: Axes;
  training_positions: Point[];
  pictures: Picture[];
  heat_maps: HeatMap[];
  splits: LevelSplits[];
  // [distance in m, share of predictions within it], ascending.
  scene_error_curve: [number, number][];
}

export interface Method extends Headline {
  name: string;
  thresholds: Threshold[];
  trajectory: {
    rmse_m: Maybe;
    aligned_rmse_m: Maybe;
    aligned_with_scale_rmse_m: Maybe;
    scale: Maybe;
  };
  confidence: Confidence;
  answers: AnswerCounts;
  training_distance: TrainingDistanceBins;
  cameras: CameraRow[];
  perturbations: Perturbed[];
  foreign: ForeignTally[];
  model_bytes: number;
  training_s: Maybe;
  evaluation_peak_memory_bytes: number;
  model_path: string | null;
  model: { checksum: string };
  per_frame: Frame[];
  page: MethodPage;
}

// A method that could not be evaluated says why, and nothing else.
export interface FailedMethod {
  name: string;
  error: string;
}

export interface SweepPoint extends Headline {
  value: number;
}

export interface Sweep {
  option: string;
  axis: string;
  name: string;
  points: SweepPoint[];
}

export interface PublishedResult {
  method: string;
  training: string;
  query: string;
  source: string;
  note: string;
  correct_percent: Maybe;
  median_cm: Maybe;
  median_deg: Maybe;
}

export interface Published {
  dataset: string;
  protocol: string;
  scene: string | null;
  scene_results: PublishedResult[];
  average_results: PublishedResult[];
}

// What every run says of itself.
interface Run {
  cpu: string;
  software_version: string;
  started_utc: string;
  command: string;
  threads: number;
}

export interface EvaluationReport extends Run {
  kind: 'evaluation';
  seed: number;
  peak_memory_bytes: number;
  dataset: string;
  frame_list: string | null;
  pose_file: string | null;
  methods: (Method | FailedMethod)[];
  sweeps: Sweep[];
  published: Published | null;
  heat_map_scale: { max_m: number; colors: string[] };
}

// The answer to one frame of treeline recognize.
export interface RecognizedFrame {
  stem: string;
  // First in the ranking of scenes, and the scene that answered; empty: none.
  first: string;
  answer: string;
  localized: boolean;
  error: string | null;
}

// One recording. scene null: it shows none of the scenes.
export interface RecognitionQuery {
  scene: string | null;
  source: string;
  frames: number;
  ranked_first: number;
  ranked_in_three: number;
  right_scene: number;
  right_localized: number;
  wrong_localized: number;
  mean_tried: number;
  errors: number;
  results: RecognizedFrame[];
}

interface MiddleTimes {
  p50: number;
  p95: number;
}

export interface RecognitionReport extends Run {
  kind: 'recognition';
  rank_only: boolean;
  scenes: string[];
  read_descriptors_ms: number;
  words_ms: MiddleTimes;
  rank_ms: MiddleTimes;
  pose_ms: MiddleTimes;
  queries: RecognitionQuery[];
}

export type Report = EvaluationReport | RecognitionReport;

export function isEvaluated(method: Method | FailedMethod): method is Method {
  return !('error' in method);
}

export function evaluated(report: EvaluationReport): Method[] {
  return report.methods.filter(isEvaluated);
}

// What the JSON text holds, or why it is no report.
export function parseReport(text: string): Report | string {
  let data: unknown;
  try {
    data = JSON.parse(text);
  } catch (error) {
    return `This is no JSON: ${error instanceof Error ? error.message : error}`;
  }
  const kind = typeof data === 'object' && data !== null && 'kind' in data ?
    (data as { kind: unknown }).kind : undefined;
  if (kind === 'evaluation' || kind === 'recognition') return data as Report;
  return 'This is JSON, but no report of treeline.';
}
