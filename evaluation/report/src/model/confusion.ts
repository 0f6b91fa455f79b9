// Which scenes frames were taken for.

import type { RecognitionQuery, RecognitionReport } from './report_data.js';

// Frames of a query by the scene that they were taken for, in the order of
// report.scenes, and last those that were taken for none.
export function answersOf(query: RecognitionQuery, report: RecognitionReport):
    number[] {
  const counts = new Array<number>(report.scenes.length + 1).fill(0);
  for (const frame of query.results) {
    let answer = '';
    if (frame.error === null) {
      answer = report.rank_only ? frame.first :
        frame.localized ? frame.answer : '';
    }
    const known = report.scenes.indexOf(answer);
    const column = known < 0 ? report.scenes.length : known;
    counts[column] = (counts[column] as number) + 1;
  }
  return counts;
}

export type Tally = Omit<RecognitionQuery, 'results'>;

// All queries of a known scene together.
export function sumOf(queries: RecognitionQuery[]): Tally {
  const known = queries.filter((query) => query.scene !== null);
  const total = (key: 'frames' | 'ranked_first' | 'ranked_in_three' |
    'right_scene' | 'right_localized' | 'wrong_localized' | 'errors') =>
    known.reduce((all, query) => all + query[key], 0);
  const frames = total('frames');
  const tried = known.reduce((all, query) =>
    all + query.mean_tried * query.frames, 0);
  return {
    scene: null,
    source: 'all',
    frames,
    ranked_first: total('ranked_first'),
    ranked_in_three: total('ranked_in_three'),
    right_scene: total('right_scene'),
    right_localized: total('right_localized'),
    wrong_localized: total('wrong_localized'),
    mean_tried: tried / Math.max(frames, 1),
    errors: total('errors'),
  };
}
