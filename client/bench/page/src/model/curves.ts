// What the charts show, as points.

import type { BenchData, Latency, Run } from './bench_data.js';

export const PERCENTILES = ['p50', 'p90', 'p99'] as const;
export type Percentile = typeof PERCENTILES[number];

export interface LoadPoint {
  run: number;
  percentile: Percentile;
  throughput_per_s: number;
  latency_ms: number;
}

// Latency by throughput: answers a second of each run, in the order of the
// load, so that beyond saturation a curve bends back.
export function loadPoints(runs: Run[]): LoadPoint[] {
  return runs.flatMap((run, i) => run.latency_ms === null ? [] :
    PERCENTILES.map((percentile) => ({
      run: i,
      percentile,
      throughput_per_s: run.answers_per_s,
      latency_ms: (run.latency_ms as Latency)[percentile],
    })));
}

// "40/s", "8 clients", "8 clients, streams of 4".
export function loadName(run: Run): string {
  if (run.loop === 'open') return `${round(run.rate_per_s ?? 0)}/s`;
  const clients = run.concurrency === 1 ? '1 client' :
    `${run.concurrency} clients`;
  return run.stream_window > 0 ? `${clients}, streams of ${run.stream_window}` :
    clients;
}

export function round(value: number): string {
  return value >= 100 || Number.isInteger(value) ? value.toFixed(0) :
    value.toFixed(1);
}

// What was offered, and what became of it, of the open loops.
export interface OfferPoint {
  offered_per_s: number;
  what: 'answered' | 'turned away' | 'too late' | 'failed';
  per_s: number;
}

export function offerPoints(runs: Run[]): OfferPoint[] {
  return runs.filter((run) => run.loop === 'open' && run.measured_s > 0)
      .flatMap((run) => {
        const of = (what: OfferPoint['what'], count: number): OfferPoint => ({
          offered_per_s: run.rate_per_s ?? 0,
          what,
          per_s: count / run.measured_s,
        });
        return [of('answered', run.counts.ok),
          of('turned away', run.counts.shed),
          of('too late', run.counts.deadline),
          of('failed', run.counts.failed)];
      });
}

// Where the time of a run goes, on the average, in the order of a query's way.
export const STAGES = ['queue', 'decode', 'sample', 'forest', 'pose',
  'rest of the server', 'outside the server'] as const;

export interface StagePart {
  run: number;
  load: string;
  stage: typeof STAGES[number];
  mean_ms: number;
}

export function stageParts(runs: Run[]): StagePart[] {
  return runs.flatMap((run, i) => {
    const mean = (name: string): number => run.server[name]?.mean ?? 0;
    if (run.server['total_ms'] === null) return [];
    const known = ['queue_ms', 'decode_ms', 'sample_ms', 'forest_ms', 'pose_ms']
        .map(mean);
    const sum = known.reduce((a, b) => a + b, 0);
    const parts = [...known, Math.max(0, mean('total_ms') - sum),
      mean('outside_ms')];
    return STAGES.map((stage, k) =>
      ({ run: i, load: loadName(run), stage, mean_ms: parts[k] ?? 0 }));
  });
}

// The course of all runs, in seconds since the first began.
export interface CourseDot {
  at_s: number;
  run: number;
  answers_per_s: number;
  p99_ms: number | null;
}

export function startOf(data: BenchData): number {
  return data.runs[0]?.measured_from_unix_s ?? 0;
}

export function courseDots(data: BenchData): CourseDot[] {
  const start = startOf(data);
  return data.runs.flatMap((run, i) => run.intervals.map((each, k) => {
    const next = run.intervals[k + 1]?.at_s ?? run.measured_s;
    const length = Math.max(next - each.at_s, 1e-3);
    return {
      at_s: run.measured_from_unix_s - start + each.at_s,
      run: i,
      answers_per_s: each.ok / length,
      p99_ms: each.ok > 0 ? each.p99_ms : null,
    };
  }));
}

// The heaviest load whose run has no failure, for people: "60/s"; null: none
// has, or there are no conditions.
export function heaviestKept(data: BenchData): string | null {
  if (data.fail_if.length === 0) return null;
  const kept = data.runs.filter((run) => run.failures.length === 0);
  const best = kept.reduce<Run | null>((best, run) =>
    best === null || run.answers_per_s > best.answers_per_s ? run : best, null);
  return best === null ? null : loadName(best);
}

export function highestThroughput(runs: Run[]): Run | null {
  return runs.reduce<Run | null>((best, run) =>
    best === null || run.goodput_per_s > best.goodput_per_s ? run : best, null);
}
