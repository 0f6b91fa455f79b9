// The sections of the page.

import { courseChart, loadChart, offerChart, OFFER_COLORS, PERCENTILE_COLORS,
  serverChart, stageChart, STAGE_COLORS } from './charts.js';
import { el, type Child } from './common/dom.js';
import { card, colorLegend, number, pair, rowsTable, section, table, tile }
  from './common/report/parts.js';
import type { BenchData, Run } from './model/bench_data.js';
import { heaviestKept, highestThroughput, loadName, PERCENTILES, round,
  stageParts, STAGES } from './model/curves.js';

const TARGETS: Record<string, string> = {
  grpc: 'gRPC',
  connect: 'Connect over HTTP',
  'connect-json': 'Connect over HTTP, as JSON',
  geopose: 'the GeoPose Protocol',
};

// `numbers` are the columns of figures.
function columns(heads: string[], rows: Child[][], numbers: number[]):
    HTMLElement {
  return table(
      heads.map((head, i) => (numbers.includes(i) ? number(head) : head)),
      rows.map((row) => ({ cells: row.map((child, i) =>
        (numbers.includes(i) ? number(child) : { content: child })) })));
}

function sum(data: BenchData, of: (run: Run) => number): number {
  return data.runs.reduce((total, run) => total + of(run), 0);
}

function head(data: BenchData): Child[] {
  const best = highestThroughput(data.runs);
  const kept = heaviestKept(data);
  const wrong = sum(data, (run) => run.checks.wrong_poses);
  const different = sum(data, (run) => run.checks.different);
  const calls = sum(data, (run) => run.calls);
  const unanswered = calls - sum(data, (run) => run.counts.ok);
  const processes = data.processes > 1 ? ` from ${data.processes} processes` :
    '';
  return [
    el('p', 'eyebrow', 'Load test'),
    el('h1', {}, data.server),
    el('p', 'lede', `${calls} calls over ${TARGETS[data.target] ?? data.target}` +
      `${processes}, in ${data.runs.length === 1 ? 'one run' :
        `${data.runs.length} runs`}.`),
    el('div', 'tiles',
        tile(round(best?.goodput_per_s ?? 0), '/s', 'most answers per second'),
        best?.latency_ms ? tile(round(best.latency_ms.p99), 'ms',
            `p99 at that load (${loadName(best)})`) : null,
        kept !== null ? tile(kept, '', 'heaviest load within --fail-if') : null,
        tile(calls === 0 ? '0' : round(100 * unanswered / calls), '%',
            'calls without an answer'),
        tile(`${wrong}`, '', 'wrong poses'),
        tile(`${different}`, '', 'answers other than before')),
  ];
}

function verdict(data: BenchData): Child {
  if (data.fail_if.length === 0) return null;
  const failing = data.runs.filter((run) => run.failures.length > 0);
  return section('Verdict', `Fails if ${data.fail_if.join(', or ')}.`,
      failing.length === 0 ?
        el('p', 'good', 'Passed: none of it holds of any run.') :
        el('div', {}, el('p', 'bad', `Failed in ${failing.length} of ` +
          `${data.runs.length} runs:`), el('ul', {}, ...failing.map((run) =>
          el('li', {}, `${loadName(run)}: ${run.failures.join('; ')}`)))));
}

function load(data: BenchData): Child {
  const hollow = data.fail_if.length > 0 ?
    ' Hollow dots are runs that fail.' : '';
  return section('Latency by throughput',
      'Each dot is a run, in the order of the load: at saturation the curves ' +
      'turn up, and may turn back. Latency counts from the moment when a call ' +
      `was to be sent.${hollow}`,
      card(null, colorLegend(PERCENTILES.map((name, i) =>
        [name, PERCENTILE_COLORS[i] ?? ''])), loadChart(data)));
}

function offer(data: BenchData): Child {
  const open = data.runs.filter((run) => run.loop === 'open');
  if (open.length < 2) return null;
  return section('What was offered, and what became of it',
      'On the dashed line everything is answered.',
      card(null, colorLegend(OFFER_COLORS), offerChart(open)));
}

function stages(data: BenchData): Child {
  if (stageParts(data.runs).length === 0) return null;
  return section('Where the time goes', 'Of calls that were answered, on the ' +
    'average, as the server states it; what is left is the way to it and back.',
  card(null, colorLegend(STAGES.map((name, i) => [name, STAGE_COLORS[i] ?? ''])),
      stageChart(data.runs)));
}

function course(data: BenchData): Child {
  return section('Course', 'Over the time of the test; each run begins at a ' +
    'dashed line.',
  pair(card('Answers per second',
      courseChart(data, 'answers_per_s', 'answers/s')),
  card('p99 of each interval, ms',
      courseChart(data, 'p99_ms', 'ms'))));
}

function server(data: BenchData): Child {
  const metrics = data.server_metrics;
  if (metrics === null) return null;
  const missed = metrics.missed > 0 ?
    ` ${metrics.missed} looks failed: ${metrics.last_error}` : '';
  const about = `From ${metrics.url}, of treeline-server ${metrics.version} ` +
    `with ${metrics.workers ?? '?'} workers. Whoever else asked it is in ` +
    `these figures too.${missed}`;
  if (metrics.points.length === 0) return section('The server', about);
  return section('The server', about, el('div', 'pair',
      card('Queries that wait',
          serverChart(data, 'queue_depth', 'waiting', 1,
              metrics.queue_capacity)),
      card('Queries that are computed',
          serverChart(data, 'in_flight', 'at work', 1, metrics.workers)),
      card('Processors',
          serverChart(data, 'processors', 'processors', 1, null)),
      card('Memory, MB',
          serverChart(data, 'resident_bytes', 'MB', 1e-6, null))));
}

function runs(data: BenchData): Child {
  const rows = data.runs.map((run): Child[] => {
    const ms = (name: typeof PERCENTILES[number] | 'max'): string =>
      run.latency_ms === null ? '–' : round(run.latency_ms[name]);
    const lag = run.generator.send_lag_ms?.p99;
    return [loadName(run), round(run.answers_per_s), ms('p50'), ms('p90'),
      ms('p99'), ms('max'), `${run.counts.shed}`, `${run.counts.deadline}`,
      `${run.counts.failed}`,
      run.checks.with_truth === 0 ? '–' :
        `${run.checks.within_tolerance} of ${run.checks.with_truth}`,
      `${run.checks.wrong_poses}`,
      (run.generator.saturated ? 'SATURATED: its own figures' :
        `${round(run.generator.cpus)} processors`) +
        (lag === undefined ? '' : `, late ${round(lag)} ms`) +
        (run.interrupted ? ', interrupted' : '')];
  });
  return section('Run by run', 'Latencies in ms.', columns(
      ['load', 'answers/s', 'p50', 'p90', 'p99', 'max', 'turned away',
        'too late', 'failed', 'within tolerance', 'wrong', 'generator'],
      rows, [1, 2, 3, 4, 5, 6, 7, 8, 9, 10]));
}

function errors(data: BenchData): Child {
  const rows = data.runs.flatMap((run) => run.outcomes
      .filter((outcome) => outcome.code !== 'OK')
      .map((outcome): Child[] => [loadName(run), `${outcome.count}`,
        outcome.code, outcome.reason ?? outcome.example ?? '']));
  if (rows.length === 0) return null;
  return section('Errors', 'Calls without an answer, by what the server said.',
      columns(['load', 'calls', 'code', 'reason'], rows, [1]));
}

function origin(data: BenchData): Child {
  const { machine } = data;
  const loads = (values: number[]): string => values.map((value) =>
    value.toFixed(1)).join(', ');
  return section('Where this comes from', 'The machine is the generator\'s.',
      rowsTable([
        ['generator', `treeline-client ${machine.client_version}, gRPC ` +
          `${machine.grpc_version}`],
        ['machine', `${machine.cpu}, ${machine.cores} cores, ` +
          `${machine.system}`],
        ['load average', `${loads(machine.load_average_before)} before, ` +
          `${loads(machine.load_average_after)} after`],
        ...data.workload.map((part): [string, string] => [`scene ${part.scene}`,
          `${part.queries} queries as ${part.encoding}, ` +
          `${round(part.mean_bytes / 1000)} kB each, ${part.with_truth} with ` +
          'their true pose']),
      ]));
}

export function benchPage(data: BenchData): Child[] {
  return [...head(data), verdict(data), load(data), offer(data), stages(data),
    course(data), server(data), runs(data), errors(data), origin(data)];
}
