// What tests of the page look at.

import assert from 'node:assert/strict';

// A click is as exact as a pixel, which is about 2 cm on the map here; the
// ground's cells are 10 cm.
const NEAR_M = 0.12;

export function near(actual, wanted, by = NEAR_M) {
  assert.ok(Math.abs(actual - wanted) <= by, `${actual} is not ${wanted}`);
}

// Until an element has the text.
export const text = (page, selector, wanted) => page.waitForFunction(
    ([where, what]) => document.querySelector(where)?.textContent.includes(what),
    [selector, wanted], { polling: 50 });
