// Answers of Prometheus' HTTP API: https://prometheus.io/docs/prometheus/latest/querying/api/

export interface Point {
  series: string;
  time: Date;
  value: number;
}

export interface Alert {
  name: string;
  state: string;
  severity: string;
  summary: string;
  advice: string;
}

export type Labels = Record<string, string>;

interface Matrix {
  metric: Labels;
  values: [number, string][];
}

// "{{status}}" in the way of Grafana; without a legend, the labels.
export function legendOf(legend: string, labels: Labels): string {
  if (legend === '') {
    const pairs = Object.entries(labels).map(([name, value]) =>
      `${name}=${value}`);
    return pairs.length === 0 ? 'value' : pairs.join(' ');
  }
  return legend.replace(/\{\{\s*(\w+)\s*\}\}/g,
      (_, name: string) => labels[name] ?? '');
}

// Points of one target. What is no number (0/0) is a gap.
export function pointsOf(result: unknown, legend: string): Point[] {
  if (!Array.isArray(result)) return [];
  return (result as Matrix[]).flatMap(({ metric, values }) => {
    const series = legendOf(legend, metric ?? {});
    return (values ?? []).map(([time, value]) =>
      ({ series, time: new Date(1000 * time), value: Number(value) }));
  }).map((point) => Number.isFinite(point.value) ? point :
    { ...point, value: NaN });
}

// Each series' newest value, in the order in which they came.
export function latestOf(points: Point[]): Map<string, number> {
  const latest = new Map<string, number>();
  for (const { series, value } of points) {
    if (!Number.isNaN(value)) latest.set(series, value);
  }
  return latest;
}

export function alertsOf(data: unknown): Alert[] {
  const alerts = (data as { alerts?: unknown[] } | null)?.alerts ?? [];
  return (alerts as { labels?: Labels; annotations?: Labels;
    state?: string }[]).map((alert) => ({
    name: alert.labels?.['alertname'] ?? '',
    state: alert.state ?? '',
    severity: alert.labels?.['severity'] ?? '',
    summary: alert.annotations?.['summary'] ?? '',
    advice: alert.annotations?.['do'] ?? '',
  }));
}

export interface Scraped {
  instance: string;
  job: string;
  isUp: boolean;
  error: string;
}

export interface Targets {
  scraped: Scraped[];
  // The longest interval of them (s).
  scrapeS: number;
}

// "1m30s" in seconds.
export function secondsOf(duration: string): number {
  const UNITS: Record<string, number> =
    { ms: 0.001, s: 1, m: 60, h: 3600, d: 86400 };
  let seconds = 0;
  for (const [, number, unit] of duration.matchAll(/(\d+)(ms|s|m|h|d)/g)) {
    seconds += Number(number) * UNITS[unit as string]!;
  }
  return seconds;
}

export function targetsOf(data: unknown): Targets {
  const active = (data as { activeTargets?: unknown[] } | null)
      ?.activeTargets ?? [];
  const targets = active as { labels?: Labels; health?: string;
    lastError?: string; scrapeInterval?: string }[];
  return {
    scraped: targets.map((target) => ({
      instance: target.labels?.['instance'] ?? '',
      job: target.labels?.['job'] ?? '',
      isUp: target.health === 'up',
      error: target.lastError ?? '',
    })),
    scrapeS: Math.max(1, ...targets.map((target) =>
      secondsOf(target.scrapeInterval ?? ''))),
  };
}
