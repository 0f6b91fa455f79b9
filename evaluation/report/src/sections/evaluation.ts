// The page of treeline evaluate.

import { bytes, datasetName } from '../model/format.js';
import { isEvaluated, type EvaluationReport, type Method }
  from '../model/report_data.js';
import { comparisonVerdict, methodVerdict } from '../model/verdict.js';
import { el, type Child } from '../common/dom.js';
import { card, rowsTable, section } from '../common/report/parts.js';
import { comparison, published, sweeps } from './comparison.js';
import { methodSections, methodTiles, modelCards } from './method.js';
import { cameras, distances } from './groups.js';
import { robustness } from './robustness.js';
import { sceneCoordinates } from './scene_coordinates.js';
import { trust } from './trust.js';

export function title(name: string, eyebrow: string, lede: string):
    HTMLElement {
  return el('header', {}, el('p', 'eyebrow', eyebrow), el('h1', {}, name),
      el('p', 'lede', lede));
}

function runCard(report: EvaluationReport): HTMLElement {
  const rows: [string, string][] = [
    ['dataset', report.dataset],
    ['frames', report.frame_list ?? 'all'],
    ['ground truth', report.pose_file ?? 'the recording\'s own'],
  ];
  for (const method of report.methods) {
    rows.push([report.methods.length === 1 ? 'model' :
      `model of ${method.name}`,
    isEvaluated(method) ? method.model_path ?? 'none: a baseline' : 'none']);
  }
  rows.push(['seed', `${report.seed}`], ['threads', `${report.threads}`],
      ['machine', report.cpu],
      ['peak memory', bytes(report.peak_memory_bytes)],
      ['software', `treeline ${report.software_version}`],
      ['started', report.started_utc]);
  return card('Evaluation', rowsTable(rows));
}

function provenance(report: EvaluationReport, single: Method | null):
    HTMLElement {
  return section('Where this comes from',
      'What was measured, with what, and how the model came about.',
      el('div', 'cards', runCard(report),
          ...(single === null ? [] : modelCards(single))),
      el('h3', 'sub', 'Command'), el('pre', {}, report.command));
}

function folded(method: Method, report: EvaluationReport): HTMLElement {
  return el('details', 'method',
      el('summary', {}, el('b', {}, method.name), ' ',
          el('span', {}, methodVerdict(method))),
      methodTiles(method), ...methodSections(method, report),
      section('The model', 'What its file says about itself.',
          el('div', 'cards', ...modelCards(method))));
}

const EYEBROW = 'Treeline evaluation';

// One method that worked; several, and one that failed, are compared.
function single(report: EvaluationReport): Method | null {
  const [only] = report.methods;
  return report.methods.length === 1 && only !== undefined &&
    isEvaluated(only) ? only : null;
}

export function evaluationPage(report: EvaluationReport): Child[] {
  const only = single(report);
  const rest = [distances(report), cameras(report), robustness(report),
    sceneCoordinates(report), sweeps(report), ...trust(report),
    published(report)];
  if (only !== null) {
    return [title(datasetName(report.dataset), EYEBROW, methodVerdict(only)),
      methodTiles(only), ...methodSections(only, report), ...rest,
      provenance(report, only)];
  }
  return [
    title(datasetName(report.dataset), EYEBROW, comparisonVerdict(report.methods)),
    comparison(report), ...rest,
    section('Method by method',
        'Unfold a method to see its frames, pictures and trajectory.',
        ...report.methods.filter(isEvaluated).map((method) =>
          folded(method, report))),
    provenance(report, null)];
}
