// The dashboard's page in a real browser, served by a real Prometheus that
// scrapes what stands for servers.

import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { once } from 'node:events';
import fs from 'node:fs';
import http from 'node:http';
import net from 'node:net';
import os from 'node:os';
import path from 'node:path';
import { after, before, test } from 'node:test';

import { assertAccessible } from '../page/accessibility.js';
import { launch, wrongsOf } from '../page/browser.js';

const WORK = process.env.TREELINE_DASHBOARD_WORK;
const EVIL = '<img src=x onerror=alert(1)>';
const folder =
  fs.mkdtempSync(path.join(os.tmpdir(), 'treeline-dashboard-'));
let browser = null;
let server = null;

// A server's /metrics, whose counters go up with every look at them.
function startServer() {
  let calls = 0;
  server = http.createServer((_, answer) => {
    calls += 50;
    answer.setHeader('Content-Type', 'text/plain; version=0.0.4');
    answer.end(`
treeline_requests_total{rpc="Localize",status="OK"} ${calls}
treeline_requests_total{rpc="Localize",status="${EVIL}"} ${calls / 10}
treeline_request_seconds_bucket{rpc="Localize",le="0.01"} ${calls / 2}
treeline_request_seconds_bucket{rpc="Localize",le="+Inf"} ${calls}
treeline_queue_depth 3
treeline_queue_capacity 64
treeline_scenes{state="READY"} 2
process_resident_memory_bytes 1.2e8
treeline_build_info{version="1.2.3"} 1
`);
  });
  server.listen(0, '127.0.0.1');
  return once(server, 'listening').then(() => server.address().port);
}

async function freePort() {
  const socket = net.createServer().listen(0, '127.0.0.1');
  await once(socket, 'listening');
  const { port } = socket.address();
  socket.close();
  await once(socket, 'close');
  return port;
}

// Its address, when it is ready; killed after the test.
async function startPrometheus(t, targets) {
  const port = await freePort();
  const data = fs.mkdtempSync(path.join(folder, 'data-'));
  const config = path.join(data, 'prometheus.yml');
  fs.writeFileSync(config, JSON.stringify({
    global: { scrape_interval: '1s', evaluation_interval: '1s' },
    rule_files: [process.env.TREELINE_DASHBOARD_RULES],
    scrape_configs: [{ job_name: 'treeline', static_configs: [{ targets }] }],
  }));
  const child = spawn(process.env.TREELINE_PROMETHEUS, [
    `--config.file=${config}`, `--storage.tsdb.path=${data}/data`,
    `--web.listen-address=127.0.0.1:${port}`,
    `--web.user-assets=${process.env.TREELINE_DASHBOARD}`], { stdio: 'ignore' });
  const ended = once(child, 'exit');
  const stop = async () => {
    child.kill('SIGKILL');
    await ended;
  };
  t.after(stop);
  const address = `http://127.0.0.1:${port}`;
  for (;;) {
    assert.equal(child.exitCode, null, 'Prometheus ended');
    const answer = await fetch(`${address}/-/ready`).catch(() => null);
    if (answer?.ok) return { address, stop };
    await new Promise((resume) => setTimeout(resume, 100));
  }
}

async function open(t, address, expected = null, options = {}) {
  const context = await browser.newContext(options);
  context.setDefaultTimeout(60000);
  t.after(() => context.close());
  const page = await context.newPage();
  const wrongs = wrongsOf(page, address, expected);
  await page.goto(`${address}/user/`);
  await page.waitForSelector('body[data-shown]');
  return { page, wrongs };
}

const panel = (page, title) => page.locator(`[data-panel="${title}"]`);

before(async () => {
  browser = await launch(WORK);
});
after(async () => {
  await browser?.close();
  server?.close();
  fs.rmSync(folder, { recursive: true });
});

test('draws what servers say, and names who does not answer', async (t) => {
  const port = await startServer();
  const dead = `127.0.0.1:${await freePort()}`;
  const { address } = await startPrometheus(t, [`127.0.0.1:${port}`, dead]);
  const { page, wrongs } = await open(t, address);
  // Rates need two samples.
  await panel(page, 'Answers').getByText(/^OK [1-9]\S*\/s$/).waitFor();
  await panel(page, 'Queue').getByText(/^capacity of one 64$/).waitFor();
  await panel(page, 'Memory').getByText(/ 114 MiB$/).waitFor();
  await panel(page, 'Versions').getByText('1.2.3 1').waitFor();
  await panel(page, 'Why not').getByText('Nothing in this time.').waitFor();
  assert.ok(await panel(page, 'Answers').locator('g[data-mark=line] path')
      .count() >= 1);
  // Labels are text.
  await panel(page, 'Answers').getByText(EVIL).first().waitFor();
  assert.equal(await page.locator('img').count(), 0);
  await page.locator('#watched').getByText(
      new RegExp(`${dead} does not answer: .*refused`)).waitFor();
  await page.locator('#alerts [data-state=pending]', {
    hasText: `${dead} does not answer` }).waitFor();
  assert.doesNotMatch(await page.locator('main').textContent(),
      /NaN|undefined|\[object/);
  await assertAccessible(page, WORK);
  assert.deepEqual(wrongs, []);
});

test('another time is shown, on a phone too', async (t) => {
  const port = server.address().port;
  const { address } = await startPrometheus(t, [`127.0.0.1:${port}`]);
  const { page, wrongs } = await open(t, address, null,
      { viewport: { width: 390, height: 844 } });
  const asked = page.waitForRequest((request) =>
    request.url().includes('step=2520'));
  await page.selectOption('#range', { label: '1 week' });
  await asked;
  await panel(page, 'Queue').locator('svg').waitFor();
  assert.ok(await page.evaluate(() =>
    document.documentElement.scrollWidth <= window.innerWidth));
  assert.deepEqual(wrongs, []);
});

test('says when Prometheus is gone, and keeps what it showed', async (t) => {
  const port = server.address().port;
  const { address, stop } = await startPrometheus(t, [`127.0.0.1:${port}`]);
  const { page } = await open(t, address, /ERR_CONNECTION_REFUSED/);
  await panel(page, 'Versions').getByText('1.2.3 1').waitFor();
  await stop();
  await page.locator('#state').getByText(/Prometheus does not answer/).waitFor();
  assert.equal(await panel(page, 'Versions').getByText('1.2.3 1').count(), 1);
});
