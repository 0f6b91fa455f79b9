// What the forests said before a pose was fitted.

import { evaluated, isEvaluated, type EvaluationReport, type HeatMap,
  type Method } from '../model/report_data.js';
import { cm, fixed } from '../model/format.js';
import { cumulativeCurves, splitRatioMap } from '../view/charts.js';
import { el } from '../common/dom.js';
import { card, pair, section, seriesLegend } from '../common/report/parts.js';

const CURVE_END_CM = 40;

function curves(report: EvaluationReport): HTMLElement[] {
  const lines = report.methods.map((method) => ({ name: method.name,
    points: !isEvaluated(method) ? [] : method.page.scene_error_curve
        .map(([error_m, share]) => ({ x: 100 * error_m, y: share })) }));
  if (lines.every((line) => line.points.length === 0)) return [];
  return [card('Predictions within a distance of the truth',
      cumulativeCurves(lines, CURVE_END_CM, 'cm',
          [{ at: 5, label: '5 cm' }, { at: 10, label: '10 cm' }]),
      lines.length > 1 ? seriesLegend(lines.map(({ name }) => name)) : null)];
}

function splits(methods: Method[]): HTMLElement[] {
  const cards: HTMLElement[] = [];
  const seen = new Set<string>();
  for (const method of methods) {
    // Ablations may share a model.
    const { checksum } = method.model;
    if (method.page.splits.length === 0 || seen.has(checksum)) continue;
    seen.add(checksum);
    const title = 'Share of samples that go left, by level';
    cards.push(card(methods.length > 1 ? `${title}: ${method.name}` : title,
        splitRatioMap(method.page.splits)));
  }
  return cards;
}

function photo(map: HeatMap, address: string, caption: (Node | string)[]):
    HTMLElement {
  return el('figure', {}, el('img', { class: 'photo', attributes: {
    alt: map.stem, width: `${map.width}`, height: `${map.height}`,
    src: address } }), el('figcaption', {}, ...caption));
}

function heatMaps(report: EvaluationReport): HTMLElement[] {
  const methods = evaluated(report);
  const stems = new Set(methods.flatMap((method) =>
    method.page.heat_maps.map((map) => map.stem)));
  if (stems.size === 0) return [];
  const { max_m, colors } = report.heat_map_scale;
  const ramp = el('p', 'ramp', '0 ', ...colors.map((color) => {
    const step = el('i');
    step.style.background = color;
    return step;
  }), ` ${cm(max_m, 0)} cm and more`);
  const rows = [...stems].map((stem) => {
    const shown = methods.flatMap((method) => method.page.heat_maps
        .filter((map) => map.stem === stem).map((map) => ({ method, map })));
    const first = shown[0]?.map as HeatMap;
    return el('div', 'photos maps',
        photo(first, first.photo, [el('b', {}, stem)]),
        ...shown.map(({ method, map }) => photo(map, map.map,
            [el('b', {}, method.name),
              ` median ${fixed(100 * map.median_error_m, 1)} cm of ` +
              `${map.predictions} predictions`])));
  });
  return [el('h3', 'sub', 'Where in the picture predictions go wrong'),
    el('p', 'about', 'Pixels with depth, sampled densely, by the distance of ' +
      'their predicted place from the true one. Grey: not asked, or no depth ' +
      'to check by.'), ramp, ...rows];
}

export function sceneCoordinates(report: EvaluationReport):
    HTMLElement | null {
  const charts = [...curves(report), ...splits(evaluated(report))];
  const maps = heatMaps(report);
  if (charts.length + maps.length === 0) return null;
  return section('Before the pose',
      'Scene coordinates as they were predicted, against recorded depth and ' +
      'true poses (baselines predict only where a feature was matched, ' +
      'forests wherever there is a sample); and how evenly the splits of the ' +
      'forest divide what they were trained on: levels under the balanced ' +
      'objective keep near one half. (Deep down, where two samples can only ' +
      'be halved, one half stands out again.)',
      pair(...charts), ...maps);
}
