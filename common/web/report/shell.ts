// Fills the page with the report that stands in it or, where there is none,
// with one that a person chooses.

import './report.css';
import { el } from '../dom.js';
import { prepareForPaper } from './drawing.js';

// What a kind of report has of its own.
export interface Shell<Data extends object> {
  // The data in a text, or why it is none.
  parse: (text: string) => Data | string;
  show: (data: Data, place: HTMLElement) => void;
  // What wrote it.
  program: string;
  // Of the template by itself.
  title: string;
  lede: string;
  label: string;
}

const PLACEHOLDER = /^"@[A-Z_]+@"$/;

function tell(message: string, place: HTMLElement): void {
  place.append(el('p', { class: 'note bad', attributes: { role: 'alert' } },
      message));
}

function showText<Data extends object>(
    shell: Shell<Data>, text: string, place: HTMLElement): void {
  const data = shell.parse(text);
  if (typeof data === 'string') {
    tell(data, place);
    return;
  }
  try {
    shell.show(data, place);
  } catch (error) {
    tell('This report cannot be shown; was it made by another version of ' +
      `${shell.program}? ${error instanceof Error ? error.message : error}`,
    place);
    throw error;
  }
}

function ask<Data extends object>(
    shell: Shell<Data>, place: HTMLElement): void {
  const input = el('input', { attributes: { type: 'file',
    accept: '.json,application/json' } });
  input.addEventListener('change', () => {
    const [file] = input.files ?? [];
    place.querySelector('[role=alert]')?.remove();
    void file?.text().then((text) => showText(shell, text, place))
        .finally(() => {
          // The same file may be chosen again, when it has changed.
          input.value = '';
        });
  });
  place.replaceChildren(el('h1', {}, shell.title), el('p', 'lede', shell.lede),
      el('p', {}, el('label', {}, shell.label, input)));
}

export function runReport<Data extends object>(shell: Shell<Data>): void {
  const place = document.getElementById('report') as HTMLElement;
  const text =
    document.getElementById('report-data')?.textContent?.trim() ?? '';
  prepareForPaper();
  if (text === '' || PLACEHOLDER.test(text)) {
    ask(shell, place);
  } else {
    place.replaceChildren();
    showText(shell, text, place);
  }
}
