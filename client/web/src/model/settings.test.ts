import assert from 'node:assert/strict';
import { test } from 'node:test';

import type { Storage } from './notes.js';
import { Settings } from './settings.js';

function storage(): Storage {
  const kept = new Map<string, string>();
  return { getItem: (key) => kept.get(key) ?? null,
    setItem: (key, value) => { kept.set(key, value); } };
}

test('each camera has its field of view, each scene its up', () => {
  const settings = new Settings(storage(), storage());
  assert.equal(settings.fieldOfViewDeg('back'), 65);
  settings.keepFieldOfView('back', 71.5);
  assert.equal(settings.fieldOfViewDeg('back'), 71.5);
  assert.equal(settings.fieldOfViewDeg('front'), 65);
  assert.equal(settings.up('room'), '+z');
  settings.keepUp('room', '-y');
  assert.equal(settings.up('room'), '-y');
});

test('nonsense that is stored counts for nothing', () => {
  const local = storage();
  local.setItem('treeline.ar.view.back', 'Infinity');
  local.setItem('treeline.ar.up.room', 'north');
  const settings = new Settings(local, storage());
  assert.equal(settings.fieldOfViewDeg('back'), 65);
  assert.equal(settings.up('room'), '+z');
});

test('a token does not outlast the window', () => {
  const local = storage();
  const session = storage();
  new Settings(local, session).keepToken('abc');
  assert.equal(new Settings(local, session).token, 'abc');
  assert.equal(new Settings(local, storage()).token, '');
});
