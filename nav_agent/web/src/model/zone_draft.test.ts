import assert from 'node:assert/strict';
import { test } from 'node:test';

import { freeName, zoneDetail, ZoneDraft } from './zone_draft.js';

const square = (draft: ZoneDraft, level = 0): void => {
  for (const [x, y] of [[0, 0], [0, 2], [2, 2], [2, 0]]) {
    draft.add({ x, y }, level);
  }
};

test('corners make a zone from the third on', () => {
  const draft = new ZoneDraft();
  draft.add({ x: 0, y: 0 }, 0);
  draft.add({ x: 1, y: 0 }, 0);
  assert.equal(draft.isZone, false);
  draft.add({ x: 1, y: 1 }, 0);
  assert.equal(draft.isZone, true);
  draft.undo();
  assert.equal(draft.isZone, false);
});

test('a double click is one corner', () => {
  const draft = new ZoneDraft();
  assert.equal(draft.add({ x: 1, y: 1 }, 0), true);
  assert.equal(draft.add({ x: 1.01, y: 1 }, 0), false);
  assert.equal(draft.corners.length, 1);
});

test('a zone is of one level', () => {
  const draft = new ZoneDraft();
  square(draft, 0);
  draft.add({ x: 5, y: 5 }, 1);
  assert.equal(draft.corners.length, 1);
  assert.equal(draft.level, 1);
});

test('a one-way zone leads as its first side was drawn', () => {
  const draft = new ZoneDraft();
  square(draft);
  const zone = draft.zone('lane', 'one-way', 0.3);
  assert.equal(zone.direction, Math.PI / 2);
  assert.equal(zone.maxMps, 0);
  assert.equal(zone.corners.length, 4);
  assert.equal(draft.zone('slow', 'speed', 0.3).maxMps, 0.3);
});

test('names are the first that are free', () => {
  const draft = new ZoneDraft();
  square(draft);
  assert.equal(freeName('speed', []), 'Slow 1');
  assert.equal(
      freeName('speed', [draft.zone('Slow 1', 'speed', 0.2)]), 'Slow 2');
});

test('a zone says its speed and, where there are several, its level', () => {
  const draft = new ZoneDraft();
  square(draft, 1);
  assert.equal(
      zoneDetail(draft.zone('a', 'speed', 0.2), 1), 'at most 0.2 m/s');
  assert.equal(zoneDetail(draft.zone('a', 'keep-out', 0), 2),
      'keep out, level 1');
});
