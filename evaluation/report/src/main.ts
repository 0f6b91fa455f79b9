// The page of an evaluation, or of scene recognition.

import { runReport } from './common/report/shell.js';
import './style.css';
import { el } from './common/dom.js';
import { datasetName } from './model/format.js';
import { parseReport, type Report } from './model/report_data.js';
import { evaluationPage } from './sections/evaluation.js';
import { recognitionPage } from './sections/recognition.js';

function show(report: Report, place: HTMLElement): void {
  const name = report.kind === 'evaluation' ? datasetName(report.dataset) :
    'Scene recognition';
  document.title = `${name} – Treeline`;
  const content = report.kind === 'evaluation' ? evaluationPage(report) :
    recognitionPage(report);
  place.replaceChildren(...content.filter((child) => child !== null),
      el('footer', {}, `treeline ${report.software_version}, ` +
        report.started_utc));
  place.dataset['shown'] = report.kind;
}

runReport({
  parse: parseReport,
  show,
  program: 'treeline',
  title: 'Treeline report',
  lede: 'This is the template of report pages. Choose the data of a report, a ' +
    'file like result.data.json.',
  label: 'Report: ',
});
