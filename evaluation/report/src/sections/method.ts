// What a report says about one method.

import { errorDots } from '../model/curves.js';
import { bytes, cm, counted, fixed, percent } from '../model/format.js';
import { explanation, hardest, isNear, quantile, refusalText, valuesOf }
  from '../model/frames.js';
import type { EvaluationReport, Frame, Maybe, Method, Picture, Stages }
  from '../model/report_data.js';
import { cumulativeChart, errorChart, histogramChart, type Mark }
  from '../view/charts.js';
import { el, svg } from '../common/dom.js';
import { card, legend, number, pair, rowsTable, section, table, tile, type Row }
  from '../common/report/parts.js';
import { trajectoryChart, turntable } from '../view/space_charts.js';

const HARDEST = 10;

export function methodTiles(method: Method): HTMLElement {
  const tiles = [
    tile(percent(method.correct_5cm_5deg), '', 'within 5 cm and 5°'),
    tile(percent(method.correct_2cm_2deg), '', 'within 2 cm and 2°'),
    tile(cm(method.median_translation_m, 2), 'cm',
        `median error, and ${fixed(method.median_rotation_deg, 2)}°`),
  ];
  if (method.latency_ms.p50 !== null) {
    tiles.push(tile(fixed(method.latency_ms.p50, 1), 'ms',
        `median, p99 ${fixed(method.latency_ms.p99, 1)} ms`));
  }
  if (method.model_bytes > 0) {
    const [size = '', unit = ''] = bytes(method.model_bytes).split(' ');
    tiles.push(tile(size, unit,
        `model, ${fixed(method.training_s, 0)} s to train`));
  }
  return el('div', 'tiles', ...tiles);
}

function figures(method: Method): [string, string][] {
  const rows = method.thresholds.map(({ name, correct }): [string, string] =>
    [`within ${name}`, percent(correct)]);
  const { trajectory } = method;
  const error = (value: Maybe, more = '') =>
    value === null ? '–' : `${cm(value, 2)} cm${more}`;
  rows.push(['trajectory RMSE', error(trajectory.rmse_m)],
      ['… after rigid alignment', error(trajectory.aligned_rmse_m)],
      ['… after alignment with scale',
        error(trajectory.aligned_with_scale_rmse_m,
            `, scale ${fixed(trajectory.scale, 4)}`)]);
  return rows;
}

function accuracy(method: Method): HTMLElement | null {
  if (method.scored === 0) return null;
  const translations = valuesOf(method.per_frame, (frame) =>
    frame.translation_error_m === null ? null :
      100 * frame.translation_error_m);
  const rotations = valuesOf(method.per_frame, (f) => f.rotation_error_deg);
  return section('How far off',
      'The share of all frames with ground truth whose error is at most so ' +
      'large. Frames that were not localized never count as reached.',
      pair(card('Position', cumulativeChart(translations, method.scored, 10,
          'cm', [{ at: 2, label: '2 cm' }, { at: 5, label: '5 cm' }])),
      card('Orientation', cumulativeChart(rotations, method.scored, 6,
          'degrees', [{ at: 2, label: '2°' }, { at: 5, label: '5°' }]))),
      el('div', 'after', card('In figures', rowsTable(figures(method)))));
}

function dotLegend(): HTMLElement {
  return legend({ mark: '', text: 'within 5 cm and 5°' },
      { mark: 'bad', text: 'further off' },
      { mark: 'cross', text: 'not localized' });
}

function frameByFrame(method: Method): (HTMLElement | null)[] {
  if (method.scored === 0) return [];
  const marks: Mark[] = [{ at: 2, label: '2 cm' }, { at: 5, label: '5 cm' }];
  const dots = errorDots(method.per_frame, (_, index) => index);
  const away = errorDots(method.per_frame, (frame) =>
    frame.training_distance === null ? null :
      100 * frame.training_distance.combined_m);
  const hasTraining = away.placed.length + away.lost.length > 0;
  return [
    section('Frame by frame',
        'The position error of every frame, in the order of the list, on a ' +
        'logarithmic scale. Point at a dot to see which frame it is.',
        card(null, errorChart(dots, 'frame in the list', marks), dotLegend())),
    !hasTraining ? null : section('Away from the training frames',
        'The same errors against the distance to the nearest training ' +
        'camera. A turn by one radian counts as 1.5 m: so far does what it ' +
        'sees move.',
        card(null, errorChart(away, 'cm to the nearest training camera',
            marks), dotLegend())),
  ];
}

const KINDS = {
  worst: 'among the worst',
  median: 'about the median',
  best: 'among the best',
};

function pixels(points: number[]): string {
  let path = '';
  for (let i = 0; i + 1 < points.length; i += 2) {
    path += `M${points[i]} ${points[i + 1]}h0`;
  }
  return path;
}

function picture(shown: Picture, method: Method): HTMLElement {
  const { stem } = method.per_frame[shown.frame] as Frame;
  const size = { width: `${shown.width}`, height: `${shown.height}` };
  const image = svg('svg', { class: 'photo', role: 'img', 'aria-label': stem,
    viewBox: `0 0 ${size.width} ${size.height}`,
    style: `--dot:${shown.width / 640}` });
  image.append(svg('image', { ...size, href: shown.photo }),
      svg('path', { class: 'outlier', d: pixels(shown.outliers) }),
      svg('path', { class: 'inlier', d: pixels(shown.inliers) }));
  return el('figure', {}, image, el('figcaption', {}, el('b', {}, stem), ' ',
      el('span', {}, KINDS[shown.kind]), el('br'),
      explanation(shown, method)));
}

function pictures(method: Method): HTMLElement | null {
  if (method.page.pictures.length === 0) return null;
  return section('Pictures',
      'Each dot is a pixel whose place in the scene was predicted: green ' +
      'where the prediction agrees with the pose, red where it does not.',
      el('div', 'photos', ...method.page.pictures.map((each) =>
        picture(each, method))));
}

function trajectory(method: Method): HTMLElement | null {
  const chart = trajectoryChart(method);
  const inSpace = turntable(method);
  if (chart === null || inSpace === null) return null;
  const marks = () => legend({ mark: 'line', text: 'ground truth' },
      { mark: '', text: 'estimate' },
      { mark: 'bad', text: 'estimate beyond 5 cm or 5°' },
      ...(method.page.training_positions.length === 0 ? [] :
        [{ mark: 'gray', text: 'training cameras' }]));
  return section('Where the camera was',
      'Ground truth and estimates at one scale, seen from above, with the ' +
      'average viewing direction upwards, and from the side. A short line ' +
      'joins an estimate with its truth; pyramids show every few frames ' +
      'where the camera looked.',
      card(null, chart, marks()),
      el('div', 'after', card('In space', inSpace, marks())));
}

function percentileRow(name: string, values: number[]): Row | null {
  if (values.length === 0) return null;
  return { cells: [{ content: name, isHead: true },
    ...[0.5, 0.95, 0.99, 1].map((share) =>
      number(fixed(quantile(values, share), 2)))] };
}

function latency(method: Method, report: EvaluationReport):
    HTMLElement | null {
  const frames = method.per_frame;
  const latencies = valuesOf(frames, (frame) => frame.latency_ms);
  if (latencies.length === 0) return null;
  const stage = (key: keyof Stages) =>
    valuesOf(frames, (frame) => frame.stages?.[key] ?? null);
  const marks = ([['p50', 0.5], ['p95', 0.95], ['p99', 0.99]] as const)
      .map(([name, share]) => {
        const at = quantile(latencies, share) ?? 0;
        return { at, label: `${name} ${fixed(at, 1)}` };
      });
  const rows = [
    percentileRow('samples and descriptors', stage('sample_ms')),
    percentileRow('scene coordinates', stage('forest_ms')),
    percentileRow('pose', stage('pose_ms')),
    percentileRow('features, of the pose', stage('features_ms')),
    percentileRow('verification, of the pose', stage('verify_ms')),
    percentileRow('whole query', latencies),
    percentileRow('whole query, processor time',
        valuesOf(frames, (frame) => frame.cpu_ms)),
    percentileRow('decoding the images',
        valuesOf(frames, (frame) => frame.decode_ms)),
  ].filter((row): row is Row => row !== null);
  return section('How fast',
      'The localizer alone; decoding comes on top. ' +
      `${counted(report.threads, 'frame')} at a time on ${report.cpu}.`,
      pair(card('Queries by latency',
          histogramChart(latencies, 'ms a query', marks)),
      card('Stages', table(['ms', number('p50'), number('p95'), number('p99'),
        number('maximum')], rows))));
}

function hardestRow(frame: Frame): Row {
  const nearest = frame.training_distance;
  const stem = { content: frame.stem, class: 'stem' };
  if (frame.outcome === 'ERROR') {
    return { cells: [stem,
      { content: frame.reason ?? '', class: 'bad', span: 5 }] };
  }
  const errors = frame.translation_error_m === null ?
    [{ content: refusalText(frame), class: 'n bad', span: 2 }] :
    [number(`${cm(frame.translation_error_m, 1)} cm`,
        isNear(frame) ? '' : 'bad'),
    number(`${fixed(frame.rotation_error_deg, 2)}°`)];
  return { cells: [stem, ...errors,
    number(`${frame.inliers} of ${frame.samples}`),
    number(`${fixed(100 * (frame.inlier_ratio ?? 0), 0)} %`),
    number(nearest === null ? '–' : `${cm(nearest.translation_m, 0)} cm, ` +
      `${fixed(nearest.rotation_deg, 0)}°`)] };
}

function hardestFrames(method: Method): HTMLElement | null {
  const frames = hardest(method.per_frame, HARDEST);
  if (frames.length === 0) return null;
  return section('The hardest frames',
      'Errors and frames that were not localized first, then by position ' +
      'error.',
      card(null, table(['frame', number('position'), number('orientation'),
        number('inliers'), number('ratio'), number('nearest training camera')],
      frames.map(hardestRow))));
}

export function methodSections(method: Method, report: EvaluationReport):
    (HTMLElement | null)[] {
  return [accuracy(method), ...frameByFrame(method), pictures(method),
    trajectory(method), latency(method, report), hardestFrames(method)];
}

export function modelCards(method: Method): HTMLElement[] {
  return method.page.model_description.map(({ title, rows }) =>
    card(`Model: ${title}`, rowsTable(rows)));
}
