// The cameras in space: ground truth against estimates.

import * as Plot from '@observablehq/plot';
import { counted } from '../model/format.js';
import { frameTitle, isNear } from '../model/frames.js';
import { roundStep } from '../model/curves.js';
import type { Method, Point, Pose } from '../model/report_data.js';
import { add, boxOf, contains, dot, frustum, fromAbove, fromTheSide, length,
  positionOf, scale, subtract, thinned, truePaths, turned, withTruth,
  type Box, type Flat, type Projection, type Segment, type TrueFrame }
  from '../model/space.js';
import { el } from '../common/dom.js';
import { drawing, drawingWithRedraw } from '../common/report/drawing.js';

const FRUSTA = 14;
const TURNTABLE_FRUSTA = 24;
const TRAINING_DOTS = 300;
const VIEW_GAP = 40;

interface Whereabouts {
  frames: TrueFrame[];
  estimates: { frame: TrueFrame; pose: Pose }[];
  training: Point[];
}

function whereabouts(method: Method): Whereabouts {
  const frames = withTruth(method.per_frame);
  return {
    frames,
    estimates: frames.flatMap((frame) => frame.world_from_camera === null ?
      [] : [{ frame, pose: frame.world_from_camera }]),
    training: method.page.training_positions,
  };
}

function links(segments: Segment[], options: Plot.LinkOptions): Plot.Markish {
  return Plot.link(segments, {
    x1: (s: Segment) => s.from[0], y1: (s: Segment) => s.from[1],
    x2: (s: Segment) => s.to[0], y2: (s: Segment) => s.to[1], ...options });
}

const flatX = (at: Flat) => at[0];
const flatY = (at: Flat) => at[1];

function pathMark(paths: Point[][], project: Projection): Plot.Markish {
  // A gap between two paths is a point that is not there.
  const points = paths.flatMap((path) => [...path.map(project),
    [NaN, NaN] as Flat]);
  return Plot.line(points, { x: flatX, y: flatY, stroke: 'var(--truth)',
    strokeWidth: 1.3, strokeLinejoin: 'round' });
}

function dots(points: Flat[], options: Plot.DotOptions): Plot.Markish {
  return Plot.dot(points, { x: flatX, y: flatY, ...options });
}

interface ViewOptions {
  frustum_m: number;
  frustumCount: number;
  // Joins estimates with their truth.
  hasWhiskers: boolean;
  shows: (pose: Pose) => boolean;
  project: Projection;
}

function marksOf(where: Whereabouts, options: ViewOptions): Plot.Markish[] {
  const { project, frustum_m: depth_m } = options;
  const shown = where.estimates.filter(({ pose }) => options.shows(pose));
  const near = shown.filter(({ frame }) => isNear(frame));
  const far = shown.filter(({ frame }) => !isNear(frame));
  const chosen = new Set(thinned(where.frames, options.frustumCount));
  const frusta = (some: typeof shown) => some
      .filter(({ frame }) => chosen.has(frame))
      .flatMap(({ pose }) => frustum(pose, depth_m, project));
  const whiskers = (some: typeof shown) => some.map(({ frame, pose }) => ({
    from: project(positionOf(frame.true_world_from_camera)),
    to: project(positionOf(pose)) }));
  const places = (some: typeof shown) =>
    some.map(({ pose }) => project(positionOf(pose)));
  const lost = where.frames
      .filter((frame) => frame.world_from_camera === null)
      .map((frame) => project(positionOf(frame.true_world_from_camera)));
  const titled = shown.map(({ frame, pose }) =>
    ({ at: project(positionOf(pose)), title: frameTitle(frame) }));
  return [
    dots(where.training.map(project), { r: 1.3, fill: 'var(--faint)',
      fillOpacity: 0.55 }),
    links([...chosen].flatMap((frame) =>
      frustum(frame.true_world_from_camera, depth_m, project)),
    { stroke: 'var(--truth)', strokeWidth: 0.7, strokeOpacity: 0.5 }),
    links(frusta(near), { stroke: 'var(--accent)', strokeWidth: 0.8,
      strokeOpacity: 0.8 }),
    links(frusta(far), { stroke: 'var(--bad)', strokeWidth: 0.8,
      strokeOpacity: 0.8 }),
    ...(options.hasWhiskers ? [
      links(whiskers(near), { stroke: 'var(--accent)', strokeWidth: 1.2 }),
      links(whiskers(far), { stroke: 'var(--bad)', strokeWidth: 1.2 }),
    ] : []),
    dots(places(near), { r: 2, fill: 'var(--accent)' }),
    dots(places(far), { r: 2, fill: 'var(--bad)' }),
    dots(lost, { r: 4, symbol: 'times', stroke: 'var(--bad)',
      strokeWidth: 1.8 }),
    pathMark(truePaths(where.frames), project),
    Plot.tip(titled, Plot.pointer({ x: (d) => d.at[0], y: (d) => d.at[1],
      title: 'title', fill: 'var(--card)', stroke: 'var(--rule)' })),
  ];
}

// The projected extent of everything, at so many pixels a metre.
function view(box: Box, perMetre: number, label: string,
    marks: Plot.Markish[]): Element {
  const width = Math.max(40, perMetre * (box.high[0] - box.low[0]));
  const height = Math.max(40, perMetre * (box.high[1] - box.low[1]));
  return Plot.plot({ width, height, margin: 0, className: 'chart', axis: null,
    ariaLabel: label,
    x: { domain: [box.low[0], box.high[0]] },
    y: { domain: [box.low[1], box.high[1]] }, marks });
}

function scaleBar(perMetre: number): HTMLElement {
  const metres = roundStep(60 / perMetre);
  const bar = el('i');
  bar.style.width = `${metres * perMetre}px`;
  return el('p', 'scalebar', bar, metres < 0.995 ?
    `${Math.round(100 * metres)} cm` : `${metres} m`);
}

// From above and from the side, at one scale. null: no frame has ground truth.
export function trajectoryChart(method: Method): HTMLElement | null {
  const where = whereabouts(method);
  if (where.frames.length === 0) return null;
  const truths = where.frames.map((f) => positionOf(f.true_world_from_camera));
  const known = truths.concat(where.training);
  const { axes } = method.page;
  const size = Math.max(0.05, ...[axes.right, axes.forward, axes.up]
      .map((axis) => known.map((at) => dot(at, axis)))
      .map((along) => Math.max(...along) - Math.min(...along)));
  // Estimates somewhat off belong into the picture; wild ones would shrink it.
  const close = where.estimates.filter(({ frame }) =>
    (frame.translation_error_m ?? Infinity) <= 0.5 * size)
      .map(({ pose }) => positionOf(pose));
  const frustum_m = 0.06 * size;
  const views = [
    { name: 'from above', project: fromAbove(axes) },
    { name: 'from the side', project: fromTheSide(axes) },
  ].map((each) => ({ ...each, box:
    boxOf(known.concat(close).map(each.project), 1.3 * frustum_m) }));
  const shows = (pose: Pose) => views.every((each) =>
    contains(each.box, each.project(positionOf(pose))));
  const widths = views.map(({ box }) => box.high[0] - box.low[0]);
  const heights = views.map(({ box }) => box.high[1] - box.low[1]);
  const chart = drawing((width) => {
    const isWide = width >= 640;
    const across = isWide ? widths.reduce((a, b) => a + b) :
      Math.max(...widths);
    const perMetre = Math.min((width - (isWide ? VIEW_GAP : 0)) / across,
        440 / Math.max(...heights));
    return el('div', {}, el('div', 'views', ...views.map((each) =>
      el('figure', {}, el('figcaption', {}, each.name),
          view(each.box, perMetre, `Trajectory ${each.name}`,
              marksOf(where, { frustum_m, frustumCount: FRUSTA,
                hasWhiskers: true, shows, project: each.project }))))),
    scaleBar(perMetre));
  });
  const outside = where.estimates.filter(({ pose }) => !shows(pose)).length;
  return el('div', {}, chart, outside === 0 ? null : el('p', 'note',
      `${counted(outside, 'estimate lies', 'estimates lie')} outside this ` +
      'picture.'));
}

// The turntable itself, below the cameras: a disc with four spokes, of which
// one points where the cameras look on average.
function discMarks(method: Method, centre: Point, radius_m: number,
    project: Projection): Plot.Markish[] {
  const { forward, right } = method.page.axes;
  const rim = (turn: number): Flat => project(add(centre, scale(radius_m,
      add(scale(Math.cos(2 * Math.PI * turn), forward),
          scale(Math.sin(2 * Math.PI * turn), right)))));
  const round = Array.from({ length: 73 }, (_, k) => rim(k / 72));
  return [
    Plot.line(round, { x: flatX, y: flatY, fill: 'var(--wash)',
      stroke: 'var(--rule)' }),
    links([0, 0.25].map((turn) => ({ from: rim(turn), to: rim(turn + 0.5) })),
        { stroke: 'var(--rule)' }),
    Plot.text([rim(0)], { x: flatX, y: flatY, text: ['forward'], dy: -6,
      fill: 'var(--soft)' }),
  ];
}

// Parallel projection from somewhat above, turned by a slider. null: no frame
// has ground truth.
export function turntable(method: Method): HTMLElement | null {
  const where = whereabouts(method);
  if (where.frames.length === 0) return null;
  const { axes } = method.page;
  const all = where.frames.map((f) => positionOf(f.true_world_from_camera))
      .concat(where.training);
  const middle = scale(1 / all.length, all.reduce(add));
  let radius_m = 0.05;
  let halfHeight_m = 0.02;
  for (const at of all) {
    const from = subtract(at, middle);
    const up = dot(from, axes.up);
    halfHeight_m = Math.max(halfHeight_m, Math.abs(up));
    radius_m = Math.max(radius_m, length(subtract(from, scale(up, axes.up))));
  }
  const frustum_m = 0.14 * radius_m;
  const half: Flat = [radius_m + frustum_m, Math.sin(0.5) * radius_m +
    1.1 * Math.cos(0.5) * halfHeight_m + 0.5 * frustum_m];
  const box: Box = { low: [-half[0], -half[1]], high: half };
  const ground = subtract(middle, scale(1.1 * halfHeight_m, axes.up));
  const thin = { ...where, training: thinned(where.training, TRAINING_DOTS) };
  // Wild ones would cover the picture.
  thin.estimates = where.estimates.filter(({ frame }) =>
    (frame.translation_error_m ?? Infinity) <= radius_m);

  const slider = el('input', { attributes: { type: 'range', min: '0',
    max: '359', value: '0', 'aria-label': 'turned by degrees' } });
  const made = drawingWithRedraw((width) => {
    const project = turned(axes, middle, Number(slider.value) * Math.PI / 180);
    const perMetre = Math.min(width / (2 * half[0]), 440 / (2 * half[1]));
    return view(box, perMetre, 'Cameras in space', [
      ...discMarks(method, ground, radius_m, project),
      ...marksOf(thin, { frustum_m, frustumCount: TURNTABLE_FRUSTA,
        hasWhiskers: false, shows: () => true, project }),
    ]);
  });
  slider.addEventListener('input', made.redraw);
  return el('div', 'turntable', el('label', {}, 'turn ', slider),
      made.element);
}
