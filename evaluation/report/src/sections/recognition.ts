// The page of treeline recognize: a confusion matrix.

import { answersOf, sumOf, type Tally } from '../model/confusion.js';
import { counted, fixed } from '../model/format.js';
import type { RecognitionReport } from '../model/report_data.js';
import { el, type Child } from '../common/dom.js';
import { card, head, number, section, table, type Cell, type Row }
  from '../common/report/parts.js';
import { title } from './evaluation.js';

function nameOf(tally: Tally): string {
  return tally.scene ?? tally.source;
}

function matrixCell(tally: Tally, answer: string | null,
    count: number): Cell {
  if (count === 0) return { content: '' };
  const share = count / Math.max(tally.frames, 1);
  const color = answer === null ? 'var(--faint)' :
    answer === tally.scene ? 'var(--accent)' : 'var(--bad)';
  const content = el('span', 'share', `${count}`);
  content.style.setProperty('--shade',
      `color-mix(in srgb, ${color} ${15 + 65 * share}%, transparent)`);
  return { content, class: 'n' };
}

function matrix(report: RecognitionReport): HTMLElement {
  const answers = [...report.scenes, null];
  const rows = report.queries.map((query): Row => {
    const counts = answersOf(query, report);
    return { cells: [head(nameOf(query)), ...answers.map((answer, i) =>
      matrixCell(query, answer, counts[i] ?? 0))] };
  });
  return card(null, el('div', 'matrix', table(['', ...answers.map((answer) =>
    ({ content: el('span', {}, answer ?? 'not localized'), class: 'n' }))],
  rows)));
}

const COUNTS = [
  ['ranked_first', 'ranked 1'],
  ['ranked_in_three', 'ranked 3'],
  ['right_scene', 'right'],
  ['right_localized', 'located'],
] as const;

function figuresRow(tally: Tally): Row {
  return { cells: [head(nameOf(tally)), number(`${tally.frames}`),
    ...COUNTS.map(([key]) => number(tally.frames === 0 ? '–' :
      `${fixed(100 * tally[key] / tally.frames, 1)} %`)),
    number(`${tally.wrong_localized}`, tally.wrong_localized > 0 ? 'bad' : ''),
    number(fixed(tally.mean_tried, 2)), number(`${tally.errors}`)] };
}

function figures(report: RecognitionReport): HTMLElement {
  return card(null, table(['', number('frames'),
    ...COUNTS.map(([, name]) => number(name)), number('wrong'),
    number('tried'), number('errors')],
  [...report.queries.map((query) => figuresRow(query)),
    figuresRow(sumOf(report.queries))]));
}

function times(report: RecognitionReport): HTMLElement {
  const row = (name: string, of: { p50: number; p95: number }): Row =>
    ({ cells: [head(name), number(fixed(of.p50, 2)),
      number(fixed(of.p95, 2))] });
  return card(null, table(['ms', number('p50'), number('p95')], [
    row('words', report.words_ms), row('ranking', report.rank_ms),
    row('poses', report.pose_ms),
    { cells: [head('read descriptors'),
      number(fixed(report.read_descriptors_ms, 1)), ''] }]));
}

export function recognitionPage(report: RecognitionReport): Child[] {
  const across = report.rank_only ? 'first in the ranking' :
    'the scene that answered with a pose';
  return [
    title('Scene recognition', 'Treeline recognize',
        `Which of ${counted(report.scenes.length, 'scene')} a frame shows.`),
    section('Confusion matrix',
        `Frames by true scene (down) and ${across} (across).`,
        matrix(report)),
    section('In figures',
        'Shares are of all frames of a query: the true scene ranked first, ' +
        'and among the first three; it answered; it answered with a pose. ' +
        'Wrong: frames for which another scene answered with a pose. Tried: ' +
        'scenes in which a pose was looked for, on average.',
        figures(report)),
    section('How fast', `${counted(report.threads, 'frame')} at a time on ` +
      `${report.cpu}.`, times(report)),
    section('Where this comes from', null,
        el('pre', {}, report.command)),
  ];
}
