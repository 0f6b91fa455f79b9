// Answers a query a line with @treeline/client in Chromium:
//   node browser_client.js ORIGIN
// with TREELINE_PACKAGE, TREELINE_PACKAGE_WORK, and TREELINE_BUNDLER, a folder
// whose node_modules has esbuild and playwright-core. The page is served here,
// at ORIGIN.
import { once } from 'node:events';
import { writeFileSync } from 'node:fs';
import { createServer } from 'node:http';
import { createRequire } from 'node:module';
import { dirname, join, resolve, sep } from 'node:path';
import { createInterface } from 'node:readline';
import { fileURLToPath } from 'node:url';

import { launch } from '../page/browser.js';
import { install } from '../typescript/installed.js';

const [origin] = process.argv.slice(2);
const { TREELINE_BUNDLER } = process.env;
const here = dirname(fileURLToPath(import.meta.url));

const installed = install();
const { build } = createRequire(resolve(TREELINE_BUNDLER) + sep)('esbuild');
const entry = join(installed.root, 'entry.js');
writeFileSync(entry, `
  import * as library from '@treeline/client';
  import { ask } from ${JSON.stringify(join(here, 'ask.js'))};
  window.ask = (request) => ask(library, request);
`);
const { outputFiles: [script] } = await build({ entryPoints: [entry],
  bundle: true, format: 'iife', write: false });

const browser = await launch(TREELINE_BUNDLER);
const page = await browser.newPage();
const server = createServer((_, response) => {
  response.setHeader('Content-Type', 'text/html');
  response.end('<!doctype html><title>Matrix</title>');
}).listen(Number(new URL(origin).port), '127.0.0.1');
await once(server, 'listening');
await page.goto(`${origin}/`);
await page.addScriptTag({ content: script.text });
for await (const line of createInterface({ input: process.stdin })) {
  const answer = await page.evaluate((request) => window.ask(request),
      JSON.parse(line));
  console.log(JSON.stringify(answer));
}
await browser.close();
server.close();
installed.remove();
