// Fills the page with the result that stands in it or, where there is none,
// with one that a person chooses.

import './style.css';
import { el } from './dom.js';
import { parseBench } from './model/bench_data.js';
import { benchPage } from './page.js';

const PLACEHOLDER = /^"@[A-Z_]+@"$/;

function tell(message: string, place: HTMLElement): void {
  place.append(el('p', { class: 'note bad', role: 'alert' }, message));
}

function showText(text: string, place: HTMLElement): void {
  const data = parseBench(text);
  if (typeof data === 'string') {
    tell(data, place);
    return;
  }
  try {
    place.replaceChildren(...benchPage(data).filter((child) => child !== null));
    document.title = `Load test of ${data.server} – Treeline`;
    place.dataset['shown'] = data.kind;
  } catch (error) {
    tell('This result cannot be shown; was it made by another version of ' +
      `treeline-client? ${error instanceof Error ? error.message : error}`,
    place);
    throw error;
  }
}

function ask(place: HTMLElement): void {
  const input = el('input', { type: 'file', accept: '.json,application/json' });
  input.addEventListener('change', () => {
    const [file] = input.files ?? [];
    place.querySelector('[role=alert]')?.remove();
    void file?.text().then((text) => showText(text, place)).finally(() => {
      // The same file may be chosen again, when it has changed.
      input.value = '';
    });
  });
  place.replaceChildren(el('h1', {}, 'Load test'),
      el('p', 'lede', 'This is the template of reports of load tests. Choose ' +
        'what treeline-client bench --json wrote.'),
      el('p', {}, el('label', {}, 'Result: ', input)));
}

const place = document.getElementById('report') as HTMLElement;
const text = document.getElementById('report-data')?.textContent?.trim() ?? '';
if (text === '' || PLACEHOLDER.test(text)) {
  ask(place);
} else {
  place.replaceChildren();
  showText(text, place);
}
