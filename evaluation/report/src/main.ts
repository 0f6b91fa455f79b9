// Fills the page with the report that stands in it or, where there is none,
// with one that a person chooses.

import './style.css';
import { datasetName } from './model/format.js';
import { parseReport, type Report } from './model/report_data.js';
import { evaluationPage } from './sections/evaluation.js';
import { recognitionPage } from './sections/recognition.js';
import { el } from './view/dom.js';
import { prepareForPaper } from './view/drawing.js';

const PLACEHOLDER = /^"@[A-Z_]+@"$/;

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

function tell(message: string, place: HTMLElement): void {
  place.append(el('p', { class: 'note bad', attributes: { role: 'alert' } },
      message));
}

function showText(text: string, place: HTMLElement): void {
  const report = parseReport(text);
  if (typeof report === 'string') {
    tell(report, place);
    return;
  }
  try {
    show(report, place);
  } catch (error) {
    tell('This report cannot be shown; was it made by another version of ' +
      `treeline? ${error instanceof Error ? error.message : error}`, place);
    throw error;
  }
}

function ask(place: HTMLElement): void {
  const input = el('input', { attributes: { type: 'file',
    accept: '.json,application/json' } });
  input.addEventListener('change', () => {
    const [file] = input.files ?? [];
    place.querySelector('[role=alert]')?.remove();
    void file?.text().then((text) => showText(text, place)).finally(() => {
      // The same file may be chosen again, when it has changed.
      input.value = '';
    });
  });
  place.replaceChildren(el('h1', {}, 'Treeline report'),
      el('p', 'lede', 'This is the template of report pages. Choose the data ' +
        'of a report, a file like result.data.json.'),
      el('p', {}, el('label', {}, 'Report: ', input)));
}

const place = document.getElementById('report') as HTMLElement;
const text = document.getElementById('report-data')?.textContent?.trim() ?? '';
prepareForPaper();
if (text === '' || PLACEHOLDER.test(text)) {
  ask(place);
} else {
  place.replaceChildren();
  showText(text, place);
}
