import assert from 'node:assert/strict';
import { test } from 'node:test';

import { loadNotes, saveNotes, type Storage } from './notes.js';

function storage(): Storage & { readonly kept: Map<string, string> } {
  const kept = new Map<string, string>();
  return { kept, getItem: (key) => kept.get(key) ?? null,
    setItem: (key, value) => { kept.set(key, value); } };
}

const NOTE = { id: 'a', text: 'The fuse box',
  pointInWorldM: { x: 1, y: 2, z: 3 } };

test('a scene has its own notes', () => {
  const here = storage();
  assert.ok(saveNotes(here, 'kitchen', [NOTE]));
  assert.deepEqual(loadNotes(here, 'kitchen'), [NOTE]);
  assert.deepEqual(loadNotes(here, 'hall'), []);
});

test('what is no note is left out', () => {
  const here = storage();
  for (const stored of ['{', '7', '[null, {"id": "a"}, {"id": "a", "text": "b",' +
      '"pointInWorldM": {"x": 1, "y": null, "z": 0}}]']) {
    here.kept.set('treeline.ar.notes.kitchen', stored);
    assert.deepEqual(loadNotes(here, 'kitchen'), []);
  }
});

test('a browser that keeps nothing is told of', () => {
  const full: Storage = { getItem: () => null,
    setItem: () => { throw new Error('QuotaExceededError'); } };
  assert.equal(saveNotes(full, 'kitchen', [NOTE]), false);
});
