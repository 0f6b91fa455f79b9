// The page of a load test.

import { runReport } from './common/report/shell.js';
import './style.css';
import { parseBench, type BenchData } from './model/bench_data.js';
import { benchPage } from './page.js';

function show(data: BenchData, place: HTMLElement): void {
  place.replaceChildren(...benchPage(data).filter((child) => child !== null));
  document.title = `Load test of ${data.server} – Treeline`;
  place.dataset['shown'] = data.kind;
}

runReport({
  parse: parseBench,
  show,
  program: 'treeline-client',
  title: 'Load test',
  lede: 'This is the template of reports of load tests. Choose what ' +
    'treeline-client bench --json wrote.',
  label: 'Result: ',
});
