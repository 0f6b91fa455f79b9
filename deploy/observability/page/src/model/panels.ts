// The panels of deploy/observability/dashboard.json, which is Grafana's: the
// few parts of it that are drawn here.

export interface Target {
  expr: string;
  legend: string;
}

export interface Panel {
  title: string;
  description: string;
  unit: string;
  // One figure in place of a course.
  isStat: boolean;
  targets: Target[];
}

export interface Dashboard {
  title: string;
  panels: Panel[];
}

type Json = Record<string, unknown>;

function object(value: unknown): Json {
  return typeof value === 'object' && value !== null ? value as Json : {};
}

function list(value: unknown): unknown[] {
  return Array.isArray(value) ? value : [];
}

function text(value: unknown): string {
  return typeof value === 'string' ? value : '';
}

function panelOf(value: unknown): Panel {
  const panel = object(value);
  const defaults = object(object(panel['fieldConfig'])['defaults']);
  return {
    title: text(panel['title']),
    description: text(panel['description']),
    unit: text(defaults['unit']),
    isStat: panel['type'] === 'stat',
    targets: list(panel['targets']).map(object).map((target) => ({
      expr: text(target['expr']),
      legend: text(target['legendFormat']),
    })).filter((target) => target.expr !== ''),
  };
}

// The dashboard, or for people what is wrong with the text.
export function parseDashboard(json: string): Dashboard | string {
  let data: Json;
  try {
    data = object(JSON.parse(json));
  } catch {
    return 'This is no JSON.';
  }
  const panels = list(data['panels']).map(panelOf)
      .filter((panel) => panel.targets.length > 0);
  if (panels.length === 0) return 'This is no dashboard: it has no panels.';
  return { title: text(data['title']), panels };
}

// What the variables of Grafana stand for: all servers, and an interval that
// holds four samples.
export function filledExpression(expr: string, stepS: number, scrapeS: number):
    string {
  const rateS = Math.ceil(Math.max(stepS + scrapeS, 4 * scrapeS));
  return expr.replaceAll('$__rate_interval', `${rateS}s`)
      .replaceAll('$instance', '.*');
}

// The step (s) of a course of so many seconds, in what a chart can show.
export function stepFor(rangeS: number, scrapeS: number): number {
  const MOST_POINTS = 240;
  return Math.max(scrapeS, Math.ceil(rangeS / MOST_POINTS));
}
