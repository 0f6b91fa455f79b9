// Frames in groups: by how far they are from training, and by camera.

import { fixed, percent } from '../model/format.js';
import { evaluated, type AnswerCounts, type EvaluationReport, type Method,
  type TrainingDistanceBin, type TrainingDistanceBins }
  from '../model/report_data.js';
import { card, head, number, section, table, type Cell, type Row }
  from '../common/report/parts.js';

const TITLES = ['right', 'answered', 'coverage', 'precision',
  'calibration error'];

function cells(counts: AnswerCounts | undefined): Cell[] {
  if (counts === undefined || counts.frames === 0) {
    return TITLES.map(() => number(''));
  }
  return [number(percent(counts.share_right)),
    number(percent(counts.share_answered)), number(percent(counts.coverage)),
    number(percent(counts.precision), counts.wrong > 0 ? 'bad' : ''),
    number(fixed(counts.calibration_error, 3))];
}

// A row a group and columns a method; `of` has the same groups of each.
function groupsTable(title: string, methods: Method[], names: string[],
    of: (method: Method) => AnswerCounts[]): HTMLElement {
  const over: Row = { cells: [head(''), head(''),
    ...methods.map((method): Cell =>
      ({ content: method.name, isHead: true, span: TITLES.length }))] };
  const rows = names.map((name, i): Row => ({ cells: [head(name),
    number(`${methods[0] === undefined ? '' : of(methods[0])[i]?.frames}`),
    ...methods.flatMap((method) => cells(of(method)[i]))] }));
  return card(title, table(['', number('frames'),
    ...methods.flatMap(() => TITLES.map((column) => number(column)))],
  methods.length === 1 ? rows : [over, ...rows]));
}

// "10 to 20 cm", "beyond 100 cm".
function range(bin: TrainingDistanceBin, unit: string, factor: number): string {
  const low = fixed(factor * bin.low, 0);
  return bin.high === null ? `beyond ${low} ${unit}` :
    `${low} to ${fixed(factor * bin.high, 0)} ${unit}`;
}

// "within 30 cm and 15°", "beyond 30 cm or 15°, within 60 cm and 30°".
function views(bin: TrainingDistanceBin): string {
  const limits = (gap: number, word: string) =>
    `${fixed(30 * gap, 0)} cm ${word} ${fixed(15 * gap, 1)}°`;
  const parts = [];
  if (bin.low > 0) parts.push(`beyond ${limits(bin.low, 'or')}`);
  if (bin.high !== null) parts.push(`within ${limits(bin.high, 'and')}`);
  return parts.join(', ');
}

export function distances(report: EvaluationReport): HTMLElement | null {
  const methods = evaluated(report).filter((method) =>
    method.training_distance.by_view_gap.length > 0);
  const [first] = methods;
  if (first === undefined) return null;
  const by = (title: string, key: keyof TrainingDistanceBins,
      name: (bin: TrainingDistanceBin) => string) =>
    groupsTable(title, methods, first.training_distance[key].map(name),
        (method) => method.training_distance[key]);
  return section('By distance from the training frames',
      'Coverage is the share of the right poses found that was answered; ' +
      'precision that of the answers to be relied on that are right.',
      by('By view: of some training camera', 'by_view_gap', views),
      by('By distance to the nearest training camera', 'by_distance_m',
          (bin) => range(bin, 'cm', 100)),
      by('By angle to it', 'by_angle_deg', (bin) => range(bin, '°', 1)));
}

export function cameras(report: EvaluationReport): HTMLElement | null {
  const methods = evaluated(report).filter((method) =>
    method.cameras.length > 1);
  const [first] = methods;
  if (first === undefined) return null;
  return section('Camera by camera', 'The frames of each of the cameras.',
      groupsTable('', methods, first.cameras.map(({ camera }) => camera),
          (method) => method.cameras));
}
