// Methods side by side: tables, curves, sweeps, published figures.

import { accuracyColumns, costColumns, inputsText, isBest, type Column }
  from '../model/columns.js';
import { cumulative } from '../model/curves.js';
import { cm, fixed, percent } from '../model/format.js';
import { valuesOf } from '../model/frames.js';
import { evaluated, isEvaluated, type EvaluationReport, type Frame, type Maybe,
  type PublishedResult, type Sweep, type SweepPoint }
  from '../model/report_data.js';
import { cumulativeCurves, lineChart } from '../view/charts.js';
import { el } from '../common/dom.js';
import { card, head, number, pair, section, seriesLegend, swatch, table,
  type Row } from '../common/report/parts.js';

function columnsTable(report: EvaluationReport, columns: Column[]):
    HTMLElement {
  const methods = evaluated(report);
  const rows = report.methods.map((method, i): Row => {
    const name = head(el('span', {}, swatch(i), method.name));
    if (!isEvaluated(method)) {
      return { cells: [name, { content: method.error, class: 'bad',
        span: columns.length + 1 }] };
    }
    return { cells: [name, inputsText(method), ...columns.map((column) => {
      const value = column.value(method);
      const best = report.methods.length > 1 &&
        isBest(column, method, methods);
      return number(value === null ? '–' : column.text(value),
          best ? 'best' : '');
    })] };
  });
  return card(null, table(['method', 'training / query',
    ...columns.map((column) => number(column.title))], rows));
}

function poseCurves(report: EvaluationReport): HTMLElement {
  const curves = (value: (frame: Frame) => Maybe, end: number) =>
    report.methods.map((method) => ({
      name: method.name,
      points: isEvaluated(method) ? cumulative(
          valuesOf(method.per_frame, value), method.scored, end) : [],
    }));
  const translations = curves((frame) => frame.translation_error_m === null ?
    null : 100 * frame.translation_error_m, 10);
  return el('div', 'after', pair(
      card('Position: share of frames within', cumulativeCurves(translations,
          10, 'cm', [{ at: 2, label: '2 cm' }, { at: 5, label: '5 cm' }])),
      card('Orientation: share of frames within',
          cumulativeCurves(curves((frame) => frame.rotation_error_deg, 6), 6,
              'degrees', [{ at: 2, label: '2°' }, { at: 5, label: '5°' }]))),
  seriesLegend(report.methods.map((method) => method.name)));
}

export function comparison(report: EvaluationReport): HTMLElement {
  const methods = evaluated(report);
  const thresholds = methods[0]?.thresholds.map(({ name }) => name) ?? [];
  return section('Side by side',
      'Shares are of all frames with ground truth: what was not localized ' +
      'counts as wrong. Medians are over localized frames alone. ATE is the ' +
      'root mean square position error after rigid alignment. The best of a ' +
      'column is bold.',
      columnsTable(report, accuracyColumns(thresholds)),
      el('div', 'after', columnsTable(report, costColumns(methods))),
      poseCurves(report));
}

function sweepCards(sweeps: Sweep[]): HTMLElement {
  const axis = sweeps[0]?.axis ?? '';
  const chart = (label: string, value: (point: SweepPoint) => Maybe,
      text: (y: number) => string, limit?: number) => {
    const lines = sweeps.map((sweep) => ({ name: sweep.name,
      points: sweep.points.flatMap((point) => {
        const y = value(point);
        return y === null ? [] : [{ x: point.value, y,
          title: `${sweep.name}, ${point.value}: ${text(y)}` }];
      }) }));
    return card(null, lineChart(lines, axis, label, limit));
  };
  const times100 = (value: Maybe) => value === null ? null : 100 * value;
  const percentText = (y: number) => `${fixed(y, 1)} %`;
  return el('div', {},
      el('h3', 'sub', axis),
      pair(
          chart('% within 5 cm / 5°',
              (point) => times100(point.correct_5cm_5deg), percentText, 100),
          chart('% within 2 cm / 2°',
              (point) => times100(point.correct_2cm_2deg), percentText, 100),
          chart('median position error, cm',
              (point) => times100(point.median_translation_m),
              (y) => `${fixed(y, 2)} cm`),
          chart('processor time, median ms', (point) => point.cpu_ms.p50,
              (y) => `${fixed(y, 2)} ms`)),
      sweeps.length > 1 ? seriesLegend(sweeps.map(({ name }) => name)) : null);
}

export function sweeps(report: EvaluationReport): HTMLElement | null {
  if (report.sweeps.length === 0) return null;
  const options = [...new Set(report.sweeps.map((sweep) => sweep.option))];
  return section('What options buy',
      'The same frames with one option changed, all others as above.',
      ...options.map((option) => sweepCards(
          report.sweeps.filter((sweep) => sweep.option === option))));
}

function publishedRow(result: PublishedResult): Row {
  return { class: 'published', cells: [head(result.method),
    `${result.training} / ${result.query}`,
    number(result.correct_percent === null ? '–' :
      `${fixed(result.correct_percent, 1)} %`),
    number(fixed(result.median_cm, 1)), number(fixed(result.median_deg, 2)),
    `published: ${[result.source, result.note].filter(Boolean).join('; ')}`] };
}

function group(title: string, results: PublishedResult[]): Row[] {
  if (results.length === 0) return [];
  const best = [...results].sort((a, b) =>
    (b.correct_percent ?? -1) - (a.correct_percent ?? -1));
  return [{ class: 'group', cells: [{ content: title, isHead: true, span: 6 }] },
    ...best.map(publishedRow)];
}

export function published(report: EvaluationReport): HTMLElement | null {
  const known = report.published;
  if (known === null) return null;
  const own = evaluated(report).map((method): Row => ({ class: 'own', cells: [
    head(method.name), inputsText(method),
    number(percent(method.correct_5cm_5deg)),
    number(cm(method.median_translation_m, 1)),
    number(fixed(method.median_rotation_deg, 2)), 'measured here'] }));
  return section('What others published',
      `Figures for ${known.dataset}, as published, with another protocol ` +
      `than ours: ${known.protocol} The rows measured here are of this ` +
      'recording with the frames and the ground truth named below, and ' +
      'cannot be ranked against the others.',
      card(null, table(['method', 'training / query', number('5 cm / 5°'),
        number('median cm'), number('median °'), 'whose'],
      [...own, ...group(`published, ${known.scene}`, known.scene_results),
        ...group(`published, average over ${known.dataset}`,
            known.average_results)])));
}
