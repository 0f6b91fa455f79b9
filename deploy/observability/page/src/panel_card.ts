// A panel: its course by Observable Plot, or its newest figures.

import * as Plot from '@observablehq/plot';
import { el, setText } from './common/dom.js';
import { drawingWithRedraw } from './common/report/drawing.js';
import { card, colorLegend, seriesColor, seriesDash } from
  './common/report/parts.js';
import type { Panel } from './model/panels.js';
import { latestOf, type Point } from './model/series.js';
import { withUnit } from './model/units.js';

const HEIGHT = 190;
const DAY_MS = 86_400_000;
// More names than these are no help below a chart.
const MOST_IN_LEGEND = 8;

// Times of a day; days where there are several.
function timeFormat(from: Date, to: Date): (time: Date) => string {
  return to.getTime() - from.getTime() > DAY_MS ?
    (time) => time.toLocaleDateString([], { month: 'short', day: 'numeric' }) :
    (time) => time.toLocaleTimeString([],
        { hour: '2-digit', minute: '2-digit', hour12: false });
}

export class PanelCard {
  readonly element: HTMLElement;
  private readonly drawing = drawingWithRedraw((width) => this.draw(width));
  private readonly legend = el('div', 'panel-legend');
  private readonly note = el('p', { class: 'note', attributes:
    { role: 'status' } });
  private points: Point[] = [];
  private from = new Date();
  private to = new Date();

  constructor(readonly panel: Panel) {
    this.element = card(panel.title,
        panel.description === '' ? null : el('p', 'note', panel.description),
        panel.isStat ? null : this.drawing.element, this.legend, this.note);
    this.element.dataset['panel'] = panel.title;
  }

  show(points: Point[], from: Date, to: Date): void {
    this.points = points;
    this.from = from;
    this.to = to;
    const latest = latestOf(points);
    setText(this.note, latest.size === 0 ? 'Nothing in this time.' : '');
    this.drawing.redraw();
    const names = this.names();
    const entries = [...latest].slice(0, MOST_IN_LEGEND)
        .map(([name, value]): [string, string] =>
          [`${name} ${withUnit(value, this.panel.unit)}`,
            seriesColor(names.indexOf(name))]);
    this.legend.replaceChildren(colorLegend(entries));
    if (latest.size > MOST_IN_LEGEND) {
      this.legend.append(`and ${latest.size - MOST_IN_LEGEND} more`);
    }
  }

  // What was shown before stays.
  showError(error: unknown): void {
    setText(this.note, error instanceof Error ? error.message : String(error));
  }

  private names(): string[] {
    return [...new Set(this.points.map(({ series }) => series))];
  }

  private draw(width: number): Element {
    const names = this.names();
    const { unit } = this.panel;
    const values = this.points.map(({ value }) => value)
        .filter((value) => !Number.isNaN(value)).concat(0);
    return Plot.plot({
      width,
      height: HEIGHT,
      marginLeft: 62,
      marginRight: 14,
      marginTop: 12,
      marginBottom: 26,
      className: 'chart',
      ariaLabel: this.panel.title,
      x: { type: 'time', domain: [this.from, this.to], label: null,
        ticks: Math.max(3, Math.floor(width / 110)),
        tickFormat: timeFormat(this.from, this.to) },
      // From 0 to 1 where all is 0.
      y: { label: null, grid: true, ticks: 4, nice: true,
        domain: [Math.min(0, ...values), Math.max(...values) || 1],
        tickFormat: (value: number) => withUnit(value, unit) },
      marks: [
        ...names.map((name, i) => Plot.line(
            this.points.filter(({ series }) => series === name),
            { x: 'time', y: 'value', stroke: seriesColor(i), strokeWidth: 1.8,
              strokeDasharray: seriesDash(i) })),
        Plot.tip(this.points, Plot.pointerX({ x: 'time', y: 'value',
          fill: 'var(--card)', stroke: 'var(--rule)',
          title: (point: Point) => `${point.time.toLocaleTimeString([],
              { hour12: false })}\n${point.series} ` +
              withUnit(point.value, unit) })),
      ],
    });
  }
}
