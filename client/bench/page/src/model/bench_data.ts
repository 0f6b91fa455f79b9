// What treeline-client bench writes: docs/reference/load-and-faults.md.

export interface Latency {
  count: number;
  mean: number;
  p50: number;
  p90: number;
  p95: number;
  p99: number;
  'p99.9': number;
  max: number;
}

export interface Counts {
  ok: number;
  shed: number;
  deadline: number;
  cancelled: number;
  failed: number;
}

export interface Interval extends Counts {
  at_s: number;
  p50_ms: number;
  p99_ms: number;
  max_ms: number;
}

export interface Outcome {
  code: string;
  reason: string | null;
  count: number;
  example: string | null;
}

export interface Run {
  loop: 'open' | 'closed';
  rate_per_s: number | null;
  concurrency: number | null;
  stream_window: number;
  deadline_ms: number;
  measured_from_unix_s: number;
  measured_s: number;
  interrupted: boolean;
  calls: number;
  counts: Counts;
  localized: number;
  answers_per_s: number;
  goodput_per_s: number;
  latency_ms: Latency | null;
  outcomes: Outcome[];
  server: Record<string, Latency | null>;
  checks: {
    different: number;
    with_truth: number;
    within_tolerance: number;
    wrong_poses: number;
  };
  generator: {
    saturated: boolean;
    not_sent: number;
    send_lag_ms: Latency | null;
    cpus: number;
  };
  failures: string[];
  intervals: Interval[];
}

export interface CoursePoint {
  at_unix_s: number;
  answers_per_s: number | null;
  shed_per_s: number | null;
  p99_ms: number | null;
  queue_depth: number | null;
  in_flight: number | null;
  processors: number | null;
  resident_bytes: number | null;
}

export interface BenchData {
  kind: 'bench';
  server: string;
  target: string;
  processes: number;
  machine: {
    cpu: string;
    cores: number;
    system: string;
    client_version: string;
    grpc_version: string;
    load_average_before: number[];
    load_average_after: number[];
  };
  workload: {
    scene: string;
    encoding: string;
    queries: number;
    with_truth: number;
    mean_bytes: number;
  }[];
  capacity_per_s: number | null;
  fail_if: string[];
  runs: Run[];
  server_metrics: {
    url: string;
    missed: number;
    last_error: string;
    version: string;
    workers: number | null;
    queue_capacity: number | null;
    points: CoursePoint[];
  } | null;
}

// The data, or for people what is wrong with the text.
export function parseBench(text: string): BenchData | string {
  let data: unknown;
  try {
    data = JSON.parse(text);
  } catch {
    return 'This is no JSON.';
  }
  const bench = data as BenchData | null;
  if (typeof bench !== 'object' || bench?.kind !== 'bench' ||
      !Array.isArray(bench.runs)) {
    return 'This is no result of treeline-client bench.';
  }
  return bench;
}
