// The numbers behind charts.

import type { Frame } from './report_data.js';
import { quantile } from './frames.js';

export interface XY {
  x: number;
  y: number;
}

// Steps of a curve of many values: as fine as a line on a screen.
const MOST_STEPS = 400;

// The share of `total` whose value is at most x, for x from 0 to `end`. What
// has no value counts in the total alone. To be drawn with steps after each
// point.
export function cumulative(values: number[], total: number, end: number): XY[] {
  const sorted = values.filter((value) => value <= end).sort((a, b) => a - b);
  const whole = Math.max(total, 1);
  const stride = Math.max(1, Math.floor(sorted.length / MOST_STEPS));
  const curve: XY[] = [{ x: 0, y: 0 }];
  for (let i = stride - 1; i < sorted.length; i += stride) {
    curve.push({ x: sorted[i] as number, y: (i + 1) / whole });
  }
  curve.push({ x: end, y: sorted.length / whole });
  return curve;
}

// The share of `total` that is below a bound.
export function shareBelow(values: number[], total: number, bound: number):
    number {
  return values.filter((value) => value < bound).length / Math.max(total, 1);
}

export interface Bin {
  from: number;
  to: number;
  count: number;
}

export interface Histogram {
  bins: Bin[];
  end: number;
  // Values past the end, which the last bin counts too.
  beyond: number;
}

// Equal bins from 0 to a round number a little past the 99th percentile.
export function histogram(values: number[], binCount = 60): Histogram {
  const high = Math.max(1.25 * (quantile(values, 0.99) ?? 0), 1e-3);
  const step = roundStep(high / 6);
  const end = Math.ceil(high / step - 1e-9) * step;
  const bins: Bin[] = [];
  for (let i = 0; i < binCount; ++i) {
    bins.push({ from: i * end / binCount, to: (i + 1) * end / binCount,
      count: 0 });
  }
  let beyond = 0;
  for (const value of values) {
    const i = Math.floor(value / end * binCount);
    if (i >= binCount) ++beyond;
    const bin = bins[Math.min(Math.max(i, 0), binCount - 1)];
    if (bin) ++bin.count;
  }
  return { bins: bins.filter((bin) => bin.count > 0), end, beyond };
}

// 1, 2 or 5 times a power of ten, at least `rough`.
export function roundStep(rough: number): number {
  const power = 10 ** Math.floor(Math.log10(rough));
  for (const factor of [1, 2, 5]) {
    if (factor * power >= rough * 0.999) return factor * power;
  }
  return 10 * power;
}

// The ends of a logarithmic axis for errors. A single lucky frame must not
// stretch it downwards.
export function errorDomain(errors: number[], marks: number[]):
    [number, number] {
  const values = errors.filter((error) => error > 0);
  const usual = quantile(values, 0.01);
  const lows = usual === null ? marks : [usual, ...marks];
  const low = lows.length === 0 ? 0.1 : Math.min(...lows);
  const high = values.concat(marks).reduce((a, b) => Math.max(a, b), 2 * low);
  return [low / 1.15, 1.15 * high];
}

// 1, 2 and 5 times the powers of ten in a range; powers alone where it is wide.
export function logTicks([low, high]: [number, number]): number[] {
  const factors = high / low > 3000 ? [1] : [1, 2, 5];
  const ticks: number[] = [];
  for (let power = Math.floor(Math.log10(low)); 10 ** power <= high; ++power) {
    ticks.push(...factors.map((factor) => factor * 10 ** power));
  }
  return ticks.filter((tick) => tick >= low && tick <= high);
}

// The vertical range of lines: from 0 unless that would flatten them, and to
// `limit` at most.
export function valueRange(values: number[], limit = Infinity):
    [number, number] {
  if (values.length === 0) return [0, 1];
  const least = Math.min(...values);
  const most = Math.max(...values);
  const spread = Math.max(most - least, 0.05 * Math.abs(most));
  const low = least >= 0 && least < 3 * spread ? 0 : least - 0.15 * spread;
  const high = Math.min(most + 0.1 * spread, limit);
  return high > low ? [low, high] : [low, low + 1];
}

export interface ErrorDot extends XY {
  frame: Frame;
}

// Frames with ground truth at a place to the right, by position error (cm);
// those that have none apart.
export function errorDots(frames: Frame[],
    place: (frame: Frame, index: number) => number | null):
    { placed: ErrorDot[]; lost: ErrorDot[] } {
  const placed: ErrorDot[] = [];
  const lost: ErrorDot[] = [];
  frames.forEach((frame, index) => {
    if (frame.true_world_from_camera === null) return;
    const x = place(frame, index);
    if (x === null) return;
    if (frame.translation_error_m === null) {
      lost.push({ x, y: 0, frame });
    } else {
      placed.push({ x, y: 100 * frame.translation_error_m, frame });
    }
  });
  return { placed, lost };
}
