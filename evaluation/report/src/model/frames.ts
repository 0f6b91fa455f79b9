// What can be said of single frames.

import { cm, fixed } from './format.js';
import type { Frame, Maybe, Method, Picture } from './report_data.js';

// A frame is correct if both errors are below these.
export const NEAR_M = 0.05;
export const NEAR_DEG = 5;

export function isWithin(frame: Frame, max_m: number, max_deg: number):
    boolean {
  return frame.translation_error_m !== null &&
    frame.rotation_error_deg !== null && frame.translation_error_m < max_m &&
    frame.rotation_error_deg < max_deg;
}

export function isNear(frame: Frame): boolean {
  return isWithin(frame, NEAR_M, NEAR_DEG);
}

// Answers that can be checked, at or above a confidence.
export function answersFrom(frames: Frame[], confidence: number): number {
  return frames.filter((frame) => frame.translation_error_m !== null &&
    (frame.confidence ?? 0) >= confidence).length;
}

const REASONS: Record<string, string> = {
  NONE: 'no reason given',
  CONTRADICTS_PRIOR: 'contradicts the prior',
};

// "too few inliers" of TOO_FEW_INLIERS.
export function reasonText(reason: string | null): string {
  if (reason === null) return 'no reason given';
  return REASONS[reason] ?? reason.toLowerCase().replaceAll('_', ' ');
}

// Why a frame was not localized, and how far off the pose is that was refused.
export function refusalText(frame: Frame): string {
  const { refused } = frame;
  if (refused === null || refused.translation_error_m === null) {
    return reasonText(frame.reason);
  }
  return `${reasonText(frame.reason)}: refused a pose ` +
    `${cm(refused.translation_error_m, 1)} cm and ` +
    `${fixed(refused.rotation_error_deg, 2)}° off`;
}

// What a dot of a chart stands for.
export function frameTitle(frame: Frame): string {
  if (frame.outcome === 'ERROR') return `${frame.stem}: error`;
  if (frame.translation_error_m === null) {
    return `${frame.stem}: not localized, ${refusalText(frame)}`;
  }
  return `${frame.stem}: ${cm(frame.translation_error_m, 1)} cm, ` +
    `${fixed(frame.rotation_error_deg, 2)}°, ${frame.inliers} of ` +
    `${frame.samples} inliers`;
}

export function median(values: number[]): Maybe {
  return quantile(values, 0.5);
}

// Interpolated linearly between the two nearest ranks; null of none.
export function quantile(values: number[], share: number): Maybe {
  if (values.length === 0) return null;
  const sorted = [...values].sort((a, b) => a - b);
  const rank = share * (sorted.length - 1);
  const below = sorted[Math.floor(rank)] as number;
  const above = sorted[Math.ceil(rank)] as number;
  return below + (above - below) * (rank - Math.floor(rank));
}

// Values of the frames that have one.
export function valuesOf(frames: Frame[], value: (frame: Frame) => Maybe):
    number[] {
  const values: number[] = [];
  for (const frame of frames) {
    const of = value(frame);
    if (of !== null) values.push(of);
  }
  return values;
}

const DIRECTIONS = {
  depth: ', mostly along the viewing direction',
  sideways: ', mostly sideways',
};

// What is known about why a pictured frame is as right or wrong as it is.
export function explanation(picture: Picture, method: Method): string {
  const frame = method.per_frame[picture.frame] as Frame;
  const parts: string[] = [];
  if (frame.outcome !== 'LOCALIZED') {
    parts.push(`Not localized: ${refusalText(frame)}.`);
  } else if (frame.translation_error_m !== null) {
    const direction = picture.error_direction;
    parts.push(`Off by ${cm(frame.translation_error_m, 1)} cm and ` +
      `${fixed(frame.rotation_error_deg, 2)}°` +
      `${direction === null ? '' : DIRECTIONS[direction]}.`);
  }
  const usual = median(valuesOf(method.per_frame,
      (other) => other.inlier_ratio)) ?? 0;
  parts.push(`${frame.inliers} of ${frame.samples} predictions agree ` +
    `(${fixed(100 * (frame.inlier_ratio ?? 0), 0)} %; the median frame has ` +
    `${fixed(100 * usual, 0)} %).`);
  if (picture.claimed_deviation_m !== null) {
    parts.push('It claims a deviation of ' +
      `${cm(picture.claimed_deviation_m, 1)} cm.`);
  }
  const nearest = frame.training_distance;
  if (nearest !== null) {
    parts.push('The nearest training camera is ' +
      `${cm(nearest.translation_m, 0)} cm and ` +
      `${fixed(nearest.rotation_deg, 0)}° away.`);
  }
  return parts.join(' ');
}

// The frames to look at first: errors, then those that were not localized, then
// by position error. Frames without ground truth that were localized say
// nothing.
export function hardest(frames: Frame[], count: number): Frame[] {
  const badness = (frame: Frame): number => {
    if (frame.outcome === 'ERROR') return 2e9;
    return frame.translation_error_m ?? 1e9;
  };
  return frames
      .filter((frame) => frame.outcome !== 'LOCALIZED' ||
        frame.translation_error_m !== null)
      .sort((a, b) => badness(b) - badness(a))
      .slice(0, count);
}
