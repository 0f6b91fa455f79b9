// Whether answers can be relied on: confidence and pictures from elsewhere.

import { counted, datasetName, fixed, percent } from '../model/format.js';
import { answersFrom } from '../model/frames.js';
import { evaluated, type EvaluationReport, type ForeignTally, type Method }
  from '../model/report_data.js';
import { reliabilityChart } from '../view/charts.js';
import { el } from '../common/dom.js';
import { card, head, number, pair, section, table, type Cell, type Row }
  from '../common/report/parts.js';

function confidenceCard(method: Method): HTMLElement {
  const { confidence } = method;
  const confident = answersFrom(method.per_frame, confidence.threshold);
  return card(method.name, reliabilityChart(confidence), el('p', 'note',
      `At ${fixed(confidence.threshold, 2)} and above: ` +
      `${counted(confident, 'answer')}, ` +
      `${percent(confidence.precision)} of them correct, which are ` +
      `${percent(confidence.recall)} of all correct ones. Expected ` +
      'calibration error ' +
      `${fixed(confidence.expected_calibration_error, 3)}.`));
}

function confidences(methods: Method[]): HTMLElement | null {
  const stated = methods.filter((method) => method.confidence.stated);
  if (stated.length === 0) return null;
  return section('Is the confidence calibrated',
      'The share of answers within 5 cm and 5°, by the confidence they came ' +
      'with. Bars on the dashed diagonal keep their word; the number above a ' +
      'bar is that of its frames.',
      pair(...stated.map(confidenceCard)));
}

// "0 of 55 (3 refused)".
function tallyCell(tally: ForeignTally | undefined): Cell {
  if (tally === undefined || tally.images === 0) return number('–');
  const notes = [];
  if (tally.refused > 0) notes.push(`${tally.refused} refused`);
  if (tally.unreadable > 0) notes.push(`${tally.unreadable} unreadable`);
  return number(`${tally.accepted} of ${tally.images}` +
    (notes.length === 0 ? '' : ` (${notes.join(', ')})`),
  tally.accepted > 0 ? 'bad' : '');
}

function foreignRows(method: Method): Row[] {
  const sources = [...new Set(method.foreign.map((tally) => tally.source))];
  return sources.map((source) => {
    const find = (withDepth: boolean) => method.foreign.find((tally) =>
      tally.source === source && tally.with_depth === withDepth);
    const tallies = [find(true), find(false)];
    const notes = tallies.flatMap((tally) => tally?.accepted_names ?? [])
        .concat(tallies[0]?.problems ?? []);
    return { cells: [head(method.name), datasetName(source),
      ...tallies.map(tallyCell), notes.join(', ')] };
  });
}

function foreign(methods: Method[]): HTMLElement | null {
  const rows = methods.flatMap(foreignRows);
  if (rows.length === 0) return null;
  return section('Pictures from elsewhere',
      'None of these shows the scene, so that every one must come back not ' +
      'localized: the figures count those that were falsely accepted. A ' +
      'method that needs depth refuses a picture without it.',
      card(null, table(['method', 'pictures',
        number('accepted, with depth'), number('accepted, without depth'),
        'which'], rows)));
}

export function trust(report: EvaluationReport): (HTMLElement | null)[] {
  const methods = evaluated(report);
  return [confidences(methods), foreign(methods)];
}
