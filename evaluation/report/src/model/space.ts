// Cameras in space, and how they are drawn in a plane.

import { quantile } from './frames.js';
import type { Axes, Frame, Point, Pose } from './report_data.js';

export const add = (a: Point, b: Point): Point =>
  [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const subtract = (a: Point, b: Point): Point =>
  [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const scale = (factor: number, a: Point): Point =>
  [factor * a[0], factor * a[1], factor * a[2]];
export const dot = (a: Point, b: Point): number =>
  a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const length = (a: Point): number => Math.hypot(...a);

export function positionOf(pose: Pose): Point {
  return [pose.tx, pose.ty, pose.tz];
}

// world_from_camera applied to a point of the camera.
export function toWorld(pose: Pose, point: Point): Point {
  const { qw: w, qx: x, qy: y, qz: z } = pose;
  const axis: Point = [x, y, z];
  const cross = (a: Point, b: Point): Point => [a[1] * b[2] - a[2] * b[1],
    a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const t = scale(2, cross(axis, point));
  return add(positionOf(pose),
      add(point, add(scale(w, t), cross(axis, t))));
}

// A point in a drawing; y upwards.
export type Flat = [number, number];
export type Projection = (point: Point) => Flat;
export type Segment = { from: Flat; to: Flat };

export function fromAbove(axes: Axes): Projection {
  return (point) => [dot(point, axes.right), dot(point, axes.forward)];
}

export function fromTheSide(axes: Axes): Projection {
  return (point) => [dot(point, axes.forward), dot(point, axes.up)];
}

// Somewhat from above, after a turn about the vertical through `middle`.
export function turned(axes: Axes, middle: Point, angle_rad: number):
    Projection {
  const elevation_rad = 0.5;
  const c = Math.cos(angle_rad);
  const s = Math.sin(angle_rad);
  return (point) => {
    const at = subtract(point, middle);
    const right = dot(at, axes.right);
    const forward = dot(at, axes.forward);
    return [c * right + s * forward,
      Math.cos(elevation_rad) * dot(at, axes.up) +
        Math.sin(elevation_rad) * (c * forward - s * right)];
  };
}

const CORNERS: Point[] = [[-0.55, -0.41, 1], [0.55, -0.41, 1], [0.55, 0.41, 1],
  [-0.55, 0.41, 1]];

// A pyramid from the camera's centre to an image `depth_m` away.
export function frustum(pose: Pose, depth_m: number, project: Projection):
    Segment[] {
  const apex = project(positionOf(pose));
  const rim = CORNERS.map((corner) =>
    project(toWorld(pose, scale(depth_m, corner))));
  return rim.flatMap((at, i) => [{ from: apex, to: at },
    { from: at, to: rim[(i + 1) % rim.length] as Flat }]);
}

export interface TrueFrame extends Frame {
  true_world_from_camera: Pose;
}

export function withTruth(frames: Frame[]): TrueFrame[] {
  return frames.filter((frame): frame is TrueFrame =>
    frame.true_world_from_camera !== null);
}

// The true positions in order, cut where the recording went on elsewhere: steps
// of eight times the usual.
export function truePaths(frames: TrueFrame[]): Point[][] {
  const positions = frames.map((f) => positionOf(f.true_world_from_camera));
  const steps = positions.slice(1).map((at, i) =>
    length(subtract(at, positions[i] as Point)));
  const longest = 8 * (quantile(steps, 0.75) ?? 0) + 0.02;
  const paths: Point[][] = [];
  positions.forEach((at, i) => {
    if (i === 0 || (steps[i - 1] as number) > longest) paths.push([]);
    paths[paths.length - 1]?.push(at);
  });
  return paths;
}

export interface Box {
  low: Flat;
  high: Flat;
}

export function boxOf(points: Flat[], margin: number): Box {
  const low: Flat = [Infinity, Infinity];
  const high: Flat = [-Infinity, -Infinity];
  for (const [x, y] of points) {
    low[0] = Math.min(low[0], x - margin);
    low[1] = Math.min(low[1], y - margin);
    high[0] = Math.max(high[0], x + margin);
    high[1] = Math.max(high[1], y + margin);
  }
  return { low, high };
}

export function contains(box: Box, [x, y]: Flat): boolean {
  return x >= box.low[0] && x <= box.high[0] && y >= box.low[1] &&
    y <= box.high[1];
}

// Every so many of a list that about `count` remain.
export function thinned<T>(all: T[], count: number): T[] {
  const stride = Math.max(1, Math.floor(all.length / count));
  return all.filter((_, i) => i % stride === 0);
}
