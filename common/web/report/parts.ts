// The pieces that sections are made of.

import { el, type Child } from '../dom.js';

// A section with a heading and what it is about.
export function section(title: string, about: Child, ...content: Child[]):
    HTMLElement {
  return el('section', {}, el('h2', {}, title),
      about === null ? null : el('p', 'about', about), ...content);
}

export function card(title: string | null, ...content: Child[]): HTMLElement {
  return el('div', 'card', title === null ? null : el('h3', {}, title),
      ...content);
}

// Cards beside each other where there is room.
export function pair(...cards: HTMLElement[]): HTMLElement {
  return el('div', 'pair', ...cards);
}

// A headline figure with its caption. "48/s", but "3.2 ms".
export function tile(value: string, unit: string, caption: string):
    HTMLElement {
  return el('div', 'tile',
      el('b', {}, value, unit === '' || unit.startsWith('/') ? null : ' ',
          unit === '' ? null : el('small', {}, unit)),
      el('span', {}, caption));
}

export interface Cell {
  content: Child;
  class?: string;
  span?: number;
  isHead?: boolean;
}

export const head = (content: Child): Cell => ({ content, isHead: true });
export const number = (content: Child, more = ''): Cell =>
  ({ content, class: `n ${more}`.trim() });

function cellOf(cell: Cell | string, isHead: boolean): HTMLElement {
  const full: Cell = typeof cell === 'string' ? { content: cell } : cell;
  // What has no words heads nothing.
  const heads = (isHead || full.isHead) && full.content !== '';
  const element = el(heads ? 'th' : 'td', {}, full.content);
  if (full.class) element.className = full.class;
  if (full.span) element.colSpan = full.span;
  return element;
}

export interface Row {
  class?: string;
  cells: (Cell | string)[];
}

// A table that scrolls by itself where it is too wide. Cells of the first row
// that are class "n" stand to the right.
export function table(heads: (Cell | string)[], rows: Row[]): HTMLElement {
  const body = rows.map((row) => el('tr', row.class ?? {},
      ...row.cells.map((cell) => cellOf(cell, false))));
  const scroll = el('div', 'scroll', el('table', {},
      heads.length === 0 ? null :
        el('thead', {}, el('tr', {}, ...heads.map((h) => cellOf(h, true)))),
      el('tbody', {}, ...body)));
  // The keyboard scrolls only what it reaches.
  new ResizeObserver(() => {
    if (scroll.scrollWidth > scroll.clientWidth) scroll.tabIndex = 0;
    else scroll.removeAttribute('tabindex');
  }).observe(scroll);
  return scroll;
}

// Names and values.
export function rowsTable(rows: [string, string][]): HTMLElement {
  return table([], rows.map(([name, value]) =>
    ({ cells: [head(name), value] })));
}

export function legend(...items: { mark: string; text: string }[]):
    HTMLElement {
  return el('ul', 'legend', ...items.map(({ mark, text }) =>
    el('li', {}, el('i', { class: mark, attributes: { 'aria-hidden': 'true' } },
        mark === 'cross' ? '×' : ''), text)));
}

const SERIES_COLORS = 8;

// The colour of line i, and whether it is dashed, for beyond the last colour
// they begin again.
export function seriesColor(i: number): string {
  return `var(--s${i % SERIES_COLORS})`;
}

export function seriesDash(i: number): string {
  return i < SERIES_COLORS ? 'none' : '6 4';
}

function colorSwatch(color: string): HTMLElement {
  const element = el('i', 'swatch');
  element.style.background = color;
  return element;
}

export function swatch(i: number): HTMLElement {
  return colorSwatch(seriesColor(i));
}

// Names and colours.
export function colorLegend(entries: [string, string][]): HTMLElement {
  return el('ul', 'legend', ...entries.map(([name, color]) =>
    el('li', {}, colorSwatch(color), name)));
}

export function seriesLegend(names: string[]): HTMLElement {
  return colorLegend(names.map((name, i) => [name, seriesColor(i)]));
}
