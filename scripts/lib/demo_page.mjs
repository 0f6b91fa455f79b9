// Keeps the operator's page open in headless Chromium and takes its picture
// whenever a line on standard input names a file.
// Usage: node demo_page.mjs WORK ADDRESS; WORK/node_modules has playwright-core.

import readline from 'node:readline';

import { launch, openPage } from '../../tests/page/browser.js';

const [work, address] = process.argv.slice(2);
const SIZE = { width: 1100, height: 700 };

const browser = await launch(work);
try {
  const { page } = await openPage(browser, `${address}/`, { viewport: SIZE });
  await page.waitForSelector('[data-map=ready]');
  for await (const file of readline.createInterface({ input: process.stdin })) {
    await page.screenshot({ path: file });
  }
} finally {
  await browser.close();
}
