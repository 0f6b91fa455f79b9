// The same frames again, changed as queries in use are.

import { DASH, fixed, percent } from '../model/format.js';
import { evaluated, type EvaluationReport, type Method, type Perturbed }
  from '../model/report_data.js';
import { el } from '../common/dom.js';
import { card, head, number, section, table, type Cell, type Row }
  from '../common/report/parts.js';

const COLUMNS = 4;

// "2", or "2 (1 gross)".
function wrongCell(row: Perturbed): Cell {
  return number(row.gross === 0 ? `${row.wrong}` :
    `${row.wrong} (${row.gross} gross)`, row.wrong > 0 ? 'bad' : '');
}

function cells(row: Perturbed | undefined): Cell[] {
  if (row === undefined) {
    return Array.from({ length: COLUMNS }, () => number(DASH));
  }
  const share = (value: number | null) =>
    number(row.is_foreign ? DASH : percent(value));
  return [share(row.share_right), share(row.share_found), wrongCell(row),
    number(fixed(row.latency_ms.p50, 1))];
}

export function robustness(report: EvaluationReport): HTMLElement | null {
  const methods = evaluated(report).filter((method: Method) =>
    method.perturbations.length > 0);
  const [first] = methods;
  if (first === undefined) return null;
  const names: Row = { cells: [head(''), ...methods.map((method): Cell =>
    ({ content: method.name, isHead: true, span: COLUMNS }))] };
  const rows = first.perturbations.map((row, i): Row => ({
    cells: [head(row.name),
      ...methods.flatMap((method) => cells(method.perturbations[i]))] }));
  const heads = methods.flatMap(() => [number('right'), number('found'),
    number('wrong'), number('p50 ms')]);
  return section('Changed pictures',
      'The same frames in other light, less sharp, half hidden, turned, with ' +
      'another camera or with poor depth. Right is the share of frames with ' +
      'an answer within the bounds, found counts poses that were refused ' +
      'too, wrong are answers that would be relied on. A mirrored picture ' +
      'shows no place at all: each of its answers is wrong.',
      card(null, table(['', ...heads], [names, ...rows]),
          el('p', 'note', first.perturbations[0] === undefined ? '' :
            `${first.perturbations[0].frames} frames a row.`)));
}
