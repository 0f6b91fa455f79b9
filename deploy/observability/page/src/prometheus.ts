// What is asked of the Prometheus that serves this page.

import { alertsOf, pointsOf, targetsOf, type Alert, type Point, type Targets }
  from './model/series.js';

const ANSWER_MS = 10_000;

// Prometheus may stand behind a prefix: the page lies in user/ of it.
const API = new URL('../api/v1/', window.location.href).href;

async function ask(path: string, parameters: Record<string, string> = {}):
    Promise<unknown> {
  const url = `${API}${path}?${new URLSearchParams(parameters)}`;
  const answer = await fetch(url, { signal: AbortSignal.timeout(ANSWER_MS) });
  const body = await answer.json().catch(() => null) as
    { status?: string; error?: string; data?: unknown } | null;
  if (body?.status !== 'success') {
    throw new Error(body?.error ?? `HTTP ${answer.status}`);
  }
  return body.data;
}

export async function course(expr: string, legend: string, endS: number,
    rangeS: number, stepS: number): Promise<Point[]> {
  // Whole steps, so that a course does not flicker as time goes on.
  const end = Math.floor(endS / stepS) * stepS;
  const data = await ask('query_range', { query: expr, step: String(stepS),
    start: String(end - rangeS), end: String(end) });
  return pointsOf((data as { result?: unknown } | null)?.result, legend);
}

export async function alerts(): Promise<Alert[]> {
  return alertsOf(await ask('alerts'));
}

export async function targets(): Promise<Targets> {
  return targetsOf(await ask('targets', { state: 'active' }));
}
