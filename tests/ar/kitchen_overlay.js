// How far from its place the AR page draws what is in a real room: 7-Scenes red
// kitchen, frames held out of training, against poses by structure from motion
// with the principal point in the middle. To be run by hand:
//   python3 tests/ar/kitchen_recording.py KITCHEN OUT
//   treeline train --dataset 7scenes:KITCHEN --poses KITCHEN/poses-sfm.txt \
//       --frames OUT/train.txt --trees 2 --repository OUT/models --scene room
//   TREELINE_SERVER=treeline-server TREELINE_SCENE=OUT TREELINE_PAGE=build/ar-page \
//       TREELINE_PAGE_WORK=build/ar-page-work node tests/ar/kitchen_overlay.js
// docs/research/service.md has the figures.

import { heldOut, HEIGHT_PX, launchWithCamera, open, startServer, truePointAt,
  waitForState, WIDTH_PX } from './fixture.js';

const FRAMES = 6;
// What a camera in a kitchen sees is so far away (m).
const DEPTHS_M = [1, 2, 3];
const SHARES = [0.1, 0.3, 0.5, 0.7, 0.9];

async function errorsPx(page, time) {
  const errors = [];
  for (const x of SHARES) {
    for (const y of SHARES) {
      for (const depthM of DEPTHS_M) {
        const drawn = await page.evaluate((at) => window.treeline.shareOf(...at),
            truePointAt(time, { x, y }, depthM));
        errors.push(drawn === null ? Infinity :
          Math.hypot((drawn.x - x) * WIDTH_PX, (drawn.y - y) * HEIGHT_PX));
      }
    }
  }
  return errors;
}

function median(values) {
  return [...values].sort((a, b) => a - b)[Math.floor(values.length / 2)];
}

const server = await startServer();
const all = [];
for (let i = 0; i < FRAMES; ++i) {
  const time = heldOut[Math.floor((i + 0.5) * heldOut.length / FRAMES)];
  const browser = await launchWithCamera(time);
  const { page } = await open(browser, server.url);
  await page.click('#start');
  await waitForState(page, 'Located');
  await page.waitForFunction(() =>
    document.querySelector('#focal').textContent.includes('as stated'));
  const errors = await errorsPx(page, time);
  console.log(`${time}: ${await page.textContent('#focal')}, median ` +
    `${median(errors).toFixed(2)} px`);
  all.push(...errors);
  await browser.close();
}
console.log(`median ${median(all).toFixed(2)} px of ${all.length} points`);
server.kill();
