// The charts of a load test, drawn by Observable Plot.

import * as Plot from '@observablehq/plot';
import { drawing } from './common/report/drawing.js';
import type { BenchData, CoursePoint, Run } from './model/bench_data.js';
import { courseDots, loadName, loadPoints, offerPoints, PERCENTILES, round,
  stageParts, STAGES, startOf, type CourseDot, type LoadPoint } from
  './model/curves.js';

const INK = 'var(--soft)';
const SERIES = ['var(--s0)', 'var(--s1)', 'var(--s2)', 'var(--s3)', 'var(--s4)',
  'var(--s5)', 'var(--s6)'];

export const PERCENTILE_COLORS = SERIES.slice(0, PERCENTILES.length);
export const STAGE_COLORS = SERIES.slice(0, STAGES.length);
export const OFFER_COLORS: [string, string][] = [['answered', 'var(--s0)'],
  ['turned away', 'var(--s2)'], ['too late', 'var(--s4)'],
  ['failed', 'var(--s3)']];

const tip: Plot.TipOptions = { fill: 'var(--card)', stroke: 'var(--rule)' };

function ticksFor(width: number): number {
  return Math.max(3, Math.min(8, Math.floor(width / 75)));
}

function frame(width: number, ariaLabel: string, options: Plot.PlotOptions):
    Element {
  return Plot.plot({
    width,
    height: Math.round(Math.min(320, Math.max(220, 0.55 * width))),
    marginLeft: 52,
    marginRight: 18,
    marginTop: 22,
    marginBottom: 38,
    className: 'chart',
    ariaLabel,
    ...options,
  });
}

// One line a percentile through the runs; those that --fail-if fails are
// hollow.
export function loadChart(data: BenchData): HTMLElement {
  const points = loadPoints(data.runs);
  const failed = (point: LoadPoint): boolean =>
    (data.runs[point.run]?.failures.length ?? 0) > 0;
  const title = (point: LoadPoint): string => {
    const run = data.runs[point.run] as Run;
    return `${loadName(run)}\n${round(point.throughput_per_s)} answers/s\n` +
      `${point.percentile} ${round(point.latency_ms)} ms` +
      (failed(point) ? `\nfails: ${run.failures.join(', ')}` : '');
  };
  return drawing((width) => frame(width, 'Latency by throughput', {
    x: { label: 'answers per second', ticks: ticksFor(width), zero: true,
      nice: true },
    y: { label: 'ms', type: 'log', grid: true, ticks: 5, tickFormat: '~s' },
    color: { domain: PERCENTILES, range: PERCENTILE_COLORS },
    marks: [
      Plot.line(points, { x: 'throughput_per_s', y: 'latency_ms',
        stroke: 'percentile', z: 'percentile', strokeWidth: 2 }),
      Plot.dot(points, { x: 'throughput_per_s', y: 'latency_ms', r: 4,
        stroke: 'percentile', strokeWidth: 2,
        fill: (point: LoadPoint) =>
          failed(point) ? 'var(--card)' : SERIES[
            PERCENTILES.indexOf(point.percentile)],
        title, tip }),
    ],
  }));
}

// Where everything is answered, the dots lie on the line.
export function offerChart(runs: Run[]): HTMLElement {
  const points = offerPoints(runs);
  const most = Math.max(...points.map((point) => point.offered_per_s));
  return drawing((width) => frame(width, 'Offered and answered', {
    x: { label: 'calls per second that were offered', ticks: ticksFor(width),
      domain: [0, most * 1.05] },
    y: { label: 'per second', grid: true, domain: [0, most * 1.05] },
    color: { domain: OFFER_COLORS.map(([name]) => name),
      range: OFFER_COLORS.map(([, color]) => color) },
    marks: [
      Plot.line([[0, 0], [most, most]], { stroke: 'var(--faint)',
        strokeDasharray: '3 4' }),
      Plot.line(points, { x: 'offered_per_s', y: 'per_s', stroke: 'what',
        strokeWidth: 2 }),
      Plot.dot(points, { x: 'offered_per_s', y: 'per_s', fill: 'what', r: 3.5,
        title: (point: typeof points[0]) =>
          `${round(point.offered_per_s)}/s offered\n` +
          `${round(point.per_s)}/s ${point.what}`, tip }),
    ],
  }));
}

export function stageChart(runs: Run[]): HTMLElement {
  const parts = stageParts(runs);
  const bars = new Set(parts.map((part) => part.run)).size;
  return drawing((width) => frame(width, 'Where the time goes', {
    height: 60 + 26 * bars,
    marginLeft: 84,
    marginTop: 8,
    x: { label: 'ms, mean', ticks: ticksFor(width), grid: true },
    y: { label: null, tickFormat: (run: number) => {
      const of = runs[run];
      return of === undefined ? '' : loadName(of).replace(/, .*/, '');
    } },
    color: { domain: STAGES, range: STAGE_COLORS },
    marks: [
      Plot.barX(parts, { y: 'run', x: 'mean_ms', fill: 'stage', insetTop: 3,
        insetBottom: 3, title: (part: typeof parts[0]) =>
          `${part.load}\n${part.stage} ${round(part.mean_ms)} ms`, tip }),
    ],
  }));
}

// The beginnings of the runs, with their loads where there is room.
function runMarks(data: BenchData, width: number): Plot.Markish[] {
  const start = startOf(data);
  const begins = data.runs.map((run) =>
    ({ at_s: run.measured_from_unix_s - start, name: loadName(run) }));
  const marks: Plot.Markish[] = [Plot.ruleX(begins, { x: 'at_s',
    stroke: 'var(--faint)', strokeDasharray: '3 4' })];
  if (begins.length * 62 < width) {
    marks.push(Plot.text(begins, { x: 'at_s', text: 'name', frameAnchor: 'top',
      textAnchor: 'start', dx: 3, dy: -14, fill: INK }));
  }
  return marks;
}

type Field = 'answers_per_s' | 'p99_ms';

export function courseChart(data: BenchData, field: Field, unit: string):
    HTMLElement {
  const dots = courseDots(data);
  return drawing((width) => frame(width, `Course of ${unit}`, {
    height: 200,
    x: { label: 's', ticks: ticksFor(width) },
    y: { label: null, grid: true, zero: true, ticks: 4 },
    marks: [
      ...runMarks(data, width),
      Plot.line(dots, { x: 'at_s', y: field, z: 'run', stroke: 'var(--s0)',
        strokeWidth: 1.8, title: (dot: CourseDot) =>
          `${round(dot.at_s)} s: ${round(dot[field] ?? 0)} ${unit}`, tip }),
    ],
  }));
}

export function serverChart(data: BenchData, field: keyof CoursePoint,
    unit: string, scale: number, limit: number | null): HTMLElement {
  const start = startOf(data);
  const points = (data.server_metrics?.points ?? []).map((point) => ({
    at_s: point.at_unix_s - start,
    value: point[field] === null ? null : (point[field] as number) * scale,
  }));
  return drawing((width) => frame(width, `Server: ${unit}`, {
    height: 180,
    x: { label: 's', ticks: ticksFor(width) },
    y: { label: null, grid: true, zero: true, ticks: 4 },
    marks: [
      ...runMarks(data, width),
      ...(limit === null ? [] : [Plot.ruleY([limit], { stroke: 'var(--bad)',
        strokeDasharray: '4 3' })]),
      Plot.line(points, { x: 'at_s', y: 'value', stroke: 'var(--s1)',
        strokeWidth: 1.8, title: (point: typeof points[0]) =>
          `${round(point.at_s)} s: ${round(point.value ?? 0)} ${unit}`, tip }),
    ],
  }));
}
