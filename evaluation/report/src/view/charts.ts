// The charts of a report, drawn by Observable Plot.

import * as Plot from '@observablehq/plot';
import { cumulative, errorDomain, histogram, logTicks, shareBelow, valueRange,
  type ErrorDot, type XY } from '../model/curves.js';
import { fixed, percent } from '../model/format.js';
import { frameTitle, isNear } from '../model/frames.js';
import type { Confidence, LevelSplits } from '../model/report_data.js';
import { drawing } from '../common/report/drawing.js';
import { seriesColor, seriesDash } from '../common/report/parts.js';

export interface Mark {
  at: number;
  label: string;
}

const INK = 'var(--soft)';
const ACCENT = 'var(--accent)';

// What all charts share.
function frame(width: number, ariaLabel: string, options: Plot.PlotOptions):
    Element {
  return Plot.plot({
    width,
    height: Math.round(Math.min(300, Math.max(220, 0.55 * width))),
    marginLeft: 46,
    marginRight: 16,
    marginBottom: 38,
    className: 'chart',
    ariaLabel,
    ...options,
  });
}

const percentAxis: Plot.ScaleOptions = {
  domain: [0, 1],
  ticks: [0, 0.25, 0.5, 0.75, 1],
  tickFormat: (share: number) => share === 1 ? '100 %' : `${100 * share}`,
  grid: true,
  label: null,
};

function ticksFor(width: number): number {
  return Math.max(3, Math.min(8, Math.floor(width / 70)));
}

const tip: Plot.TipOptions = {
  fill: 'var(--card)',
  stroke: 'var(--rule)',
};

// Vertical lines with their words beside them: at the bottom or, one below the
// other, at the top, where they may stand close.
function verticalMarks(marks: Mark[], place: 'top' | 'bottom'):
    Plot.Markish[] {
  return [
    Plot.ruleX(marks, { x: 'at', stroke: 'var(--faint)',
      strokeDasharray: '3 4' }),
    ...marks.map((mark, i) => Plot.text([mark], { x: 'at', text: 'label',
      frameAnchor: place, textAnchor: 'start', dx: 5,
      dy: place === 'top' ? 2 + 15 * i : -8, fill: INK,
      stroke: 'var(--card)', strokeWidth: 4 })),
  ];
}

// The share of `total` whose value is at most x; at each mark the figure.
export function cumulativeChart(values: number[], total: number, end: number,
    unit: string, marks: Mark[]): HTMLElement {
  const curve = cumulative(values, total, end);
  const knots = marks.map((mark) =>
    ({ ...mark, share: shareBelow(values, total, mark.at) }));
  return drawing((width) => frame(width, `Cumulative error in ${unit}`, {
    x: { domain: [0, end], label: unit, ticks: ticksFor(width) },
    y: percentAxis,
    marks: [
      Plot.areaY(curve, { x: 'x', y: 'y', curve: 'step-after',
        fill: 'var(--wash)' }),
      Plot.lineY(curve, { x: 'x', y: 'y', curve: 'step-after', stroke: ACCENT,
        strokeWidth: 2.2 }),
      Plot.ruleX(knots, { x: 'at', stroke: 'var(--faint)',
        strokeDasharray: '3 4' }),
      Plot.dot(knots, { x: 'at', y: 'share', r: 4, fill: 'var(--card)',
        stroke: ACCENT, strokeWidth: 2.2 }),
      ...knots.map((knot) => Plot.text([knot], {
        x: 'at',
        text: (at: typeof knot) =>
          `${fixed(100 * at.share, 1)} %\n${at.label}`,
        // Under the curve where there is room, else at the top.
        frameAnchor: knot.share > 0.3 ? 'bottom' : 'top',
        textAnchor: 'start', dx: 7, dy: knot.share > 0.3 ? -8 : 4,
        fill: 'var(--ink)', stroke: 'var(--card)', strokeWidth: 4 })),
    ],
  }));
}

export interface Curve {
  name: string;
  // Steps as `cumulative` makes them, or points of a line.
  points: XY[];
}

// Several such curves in the colours of their methods; the first on top.
export function cumulativeCurves(curves: Curve[], end: number, unit: string,
    marks: Mark[]): HTMLElement {
  const lines = curves.map((curve, i) => Plot.line(curve.points, {
    x: 'x', y: 'y', curve: 'step-after', stroke: seriesColor(i),
    strokeDasharray: seriesDash(i), strokeWidth: 2.2,
    title: () => curve.name }));
  return drawing((width) => frame(width, `Cumulative error in ${unit}`, {
    x: { domain: [0, end], label: unit, ticks: ticksFor(width) },
    y: percentAxis,
    marks: [...verticalMarks(marks, 'bottom'), ...lines.reverse()],
  }));
}

export function histogramChart(values: number[], unit: string, marks: Mark[]):
    HTMLElement {
  const { bins, end, beyond } = histogram(values);
  const tallest = Math.max(...bins.map((bin) => bin.count));
  return drawing((width) => frame(width, `Histogram in ${unit}`, {
    marginLeft: 16,
    x: { domain: [0, end], label: unit, ticks: ticksFor(width) },
    // The marks' words keep the top fifth.
    y: { domain: [0, tallest / 0.8], axis: null },
    marks: [
      Plot.rectY(bins, { x1: 'from', x2: 'to', y: 'count', fill: ACCENT,
        insetLeft: 0.6, insetRight: 0.6, tip,
        title: (bin: { from: number; to: number; count: number }) =>
          `${fixed(bin.from, 2)} to ${fixed(bin.to, 2)} ${unit}: ` +
          `${bin.count} frames` }),
      ...verticalMarks(marks, 'top'),
      ...(beyond === 0 ? [] : [Plot.text([`${beyond} beyond`], {
        frameAnchor: 'bottom-right', dy: -24, fill: INK })]),
    ],
  }));
}

// Position errors (cm) on a logarithmic axis; frames that were not localized as
// crosses at the top.
export function errorChart(dots: { placed: ErrorDot[]; lost: ErrorDot[] },
    label: string, marks: Mark[]): HTMLElement {
  const all = [...dots.placed, ...dots.lost];
  const end = Math.max(1e-3, ...all.map((dot) => dot.x));
  const domain = errorDomain(dots.placed.map((dot) => dot.y),
      marks.map((mark) => mark.at));
  const clamped = (dot: ErrorDot) => Math.max(dot.y, domain[0]);
  const title = (dot: ErrorDot) => frameTitle(dot.frame);
  return drawing((width) => frame(width, `Error by ${label}`, {
    marginLeft: 58,
    marginTop: 26,
    x: { domain: [0, 1.01 * end], label, ticks: ticksFor(width) },
    y: { type: 'log', domain, label: '↑ cm', grid: true,
      tickFormat: (value: number) => fixed(value, 10).replace(/\.?0+$/, ''),
      ticks: logTicks(domain) },
    marks: [
      Plot.ruleY(marks, { y: 'at', stroke: 'var(--faint)',
        strokeDasharray: '3 4' }),
      Plot.text(marks, { y: 'at', text: 'label', frameAnchor: 'right',
        textAnchor: 'end', dy: -8, fill: INK, stroke: 'var(--card)',
        strokeWidth: 4 }),
      Plot.dot(dots.placed, { x: 'x', y: clamped, r: 3.1,
        fill: (dot: ErrorDot) => isNear(dot.frame) ? ACCENT : 'var(--bad)',
        fillOpacity: 0.8 }),
      Plot.dot(dots.lost, { x: 'x', frameAnchor: 'top', r: 4, symbol: 'times',
        stroke: 'var(--bad)', strokeWidth: 1.8 }),
      Plot.tip(dots.placed, Plot.pointer({ x: 'x', y: clamped, title,
        ...tip })),
      Plot.tip(dots.lost, Plot.pointerX({ x: 'x', frameAnchor: 'top', title,
        ...tip })),
    ],
  }));
}

export interface LinePoint extends XY {
  title: string;
}

export interface Line {
  name: string;
  points: LinePoint[];
}

export function lineChart(lines: Line[], xLabel: string, yLabel: string,
    yLimit = Infinity): HTMLElement {
  const points = lines.flatMap((line) => line.points);
  const end = 1.02 * Math.max(1e-9, ...points.map((point) => point.x));
  // The first on top.
  const marks = lines.map((line, i) => [
    Plot.line(line.points, { x: 'x', y: 'y', stroke: seriesColor(i),
      strokeDasharray: seriesDash(i), strokeWidth: 2.2 }),
    Plot.dot(line.points, { x: 'x', y: 'y', r: 3.2, fill: 'var(--card)',
      stroke: seriesColor(i), strokeWidth: 2 }),
  ]).reverse();
  return drawing((width) => frame(width, `${yLabel} by ${xLabel}`, {
    marginTop: 34,
    x: { domain: [0, end], label: xLabel, ticks: ticksFor(width) },
    y: { domain: valueRange(points.map((point) => point.y), yLimit),
      label: yLabel, labelArrow: 'none', grid: true, ticks: 5 },
    marks: [marks,
      Plot.tip(points, Plot.pointer({ x: 'x', y: 'y', title: 'title',
        ...tip }))],
  }));
}

// Stated confidence to the right, the share that is correct upwards; the
// diagonal is perfect.
export function reliabilityChart(confidence: Confidence): HTMLElement {
  const bins = confidence.bins.filter((bin) => bin.frames > 0);
  return drawing((width) =>
    frame(width, 'Reliability of the stated confidence', {
      marginTop: 26,
      x: { domain: [0, 1], label: 'stated confidence', ticks: 5 },
      y: percentAxis,
      marks: [
        // A sliver shows a bin none of whose frames is correct.
        Plot.rect(bins, { x1: 'low', x2: 'high', y1: 0,
          y2: (bin) => Math.max(bin.correct ?? 0, 0.006), fill: ACCENT,
          fillOpacity: 0.8, insetLeft: 1.5, insetRight: 1.5, tip,
          title: (bin) => `stated ${fixed(100 * (bin.confidence ?? 0), 0)} ` +
            `%, correct ${fixed(100 * (bin.correct ?? 0), 0)} % of ` +
            `${bin.frames} frames` }),
        Plot.text(bins, { x: (bin) => (bin.low + bin.high) / 2,
          y: (bin) => bin.correct ?? 0, text: (bin) => `${bin.frames}`,
          dy: -8, fill: INK, stroke: 'var(--card)', strokeWidth: 3 }),
        Plot.link([0], { x1: 0, y1: 0, x2: 1, y2: 1, stroke: 'var(--faint)',
          strokeDasharray: '3 4' }),
        Plot.ruleX([confidence.threshold], { stroke: 'var(--faint)',
          strokeDasharray: '3 4' }),
      ],
    }));
}

// Levels to the right, the share of samples that go left upwards; dark where
// many splits of the level have that share (thesis Fig. 4.9).
export function splitRatioMap(levels: LevelSplits[]): HTMLElement {
  const cells = levels.flatMap((level, x) => {
    const most = Math.max(1, ...level.by_left_share);
    const bins = level.by_left_share.length;
    return level.by_left_share.map((count, bin) => ({
      x,
      low: bin / bins,
      high: (bin + 1) / bins,
      count,
      opacity: Math.max(count / most, 0.03),
      title: `level ${x}: ${percent(count / level.splits)} of ` +
        `${level.splits} splits send ${Math.round(100 * bin / bins)} to ` +
        `${Math.round(100 * (bin + 1) / bins)} % to the left`,
    })).filter((cell) => cell.count > 0);
  });
  return drawing((width) => frame(width, 'Split ratio by level', {
    x: { domain: [0, levels.length], label: 'level',
      ticks: Math.min(levels.length, ticksFor(width)) },
    y: percentAxis,
    opacity: { type: 'linear', domain: [0, 1], range: [0, 1] },
    marks: [Plot.rect(cells, { x1: 'x', x2: (cell) => cell.x + 1, y1: 'low',
      y2: 'high', fill: ACCENT, fillOpacity: 'opacity', inset: 0.5, tip,
      title: 'title' })],
  }));
}
