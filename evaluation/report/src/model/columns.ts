// The columns of a comparison.

import { bytes, fixed, percent } from './format.js';
import type { Maybe, Method } from './report_data.js';

export interface Column {
  title: string;
  value: (method: Method) => Maybe;
  text: (value: number) => string;
  // Otherwise the least is.
  greatestIsBest: boolean;
}

function least(title: string, value: (method: Method) => Maybe,
    text: (value: number) => string): Column {
  return { title, value, text, greatestIsBest: false };
}

const digits = (count: number) => (value: number) => fixed(value, count);
const hundredfold = (value: Maybe) => value === null ? null : 100 * value;

// thresholds: of the first method; all have the same.
export function accuracyColumns(thresholds: string[]): Column[] {
  const columns: Column[] = thresholds.map((title, i) => ({
    title,
    value: (method) => method.thresholds[i]?.correct ?? null,
    text: percent,
    greatestIsBest: true,
  }));
  return columns.concat(
      least('median cm', (m) => hundredfold(m.median_translation_m), digits(2)),
      least('median °', (m) => m.median_rotation_deg, digits(2)),
      least('ATE cm', (m) => hundredfold(m.trajectory.aligned_rmse_m),
          digits(2)),
      {
        title: 'localized',
        value: (m) => m.frames === 0 ? null : m.localized / m.frames,
        text: percent,
        greatestIsBest: true,
      });
}

// Foreign pictures that were taken for the scene; null: none was asked about.
export function falseAccepts(method: Method): Maybe {
  if (method.foreign.length === 0) return null;
  return method.foreign.reduce((sum, tally) => sum + tally.accepted, 0);
}

export function costColumns(methods: Method[]): Column[] {
  const columns = [
    least('p50 ms', (m) => m.latency_ms.p50, digits(1)),
    least('p95 ms', (m) => m.latency_ms.p95, digits(1)),
    least('p99 ms', (m) => m.latency_ms.p99, digits(1)),
    least('model', (m) => m.model_bytes, bytes),
    least('memory', (m) => m.evaluation_peak_memory_bytes, bytes),
    least('training s', (m) => m.training_s, digits(1)),
  ];
  if (methods.some((method) => method.foreign.length > 0)) {
    columns.push(least('false accepts', falseAccepts, digits(0)));
  }
  return columns;
}

const TIE = 1e-9;

// Whether a method's value is as good as that of any other.
export function isBest(column: Column, method: Method, methods: Method[]):
    boolean {
  const value = column.value(method);
  if (value === null) return false;
  return methods.every((other) => {
    const its = column.value(other);
    if (its === null) return true;
    return column.greatestIsBest ? value >= its - TIE : value <= its + TIE;
  });
}

// "RGB-D / RGB": what it learns from, and what it is asked with.
export function inputsText(method: Method): string {
  const inputs = method.page.inputs;
  return inputs === null ? '–' : `${inputs.training} / ${inputs.query}`;
}
