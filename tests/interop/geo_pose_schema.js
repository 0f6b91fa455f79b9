// What GeoPose answers must be, checked by ajv.
import assert from 'node:assert/strict';
import fs from 'node:fs';

import { sendRequest } from '@oarc/gpp-access';
import Ajv from 'ajv';

const number = { type: 'number' };
// All members are needed, and there are no others.
const exactly = (properties) => ({ type: 'object', properties,
  required: Object.keys(properties), additionalProperties: false });
const numbers = (...names) =>
  exactly(Object.fromEntries(names.map((name) => [name, number])));

// The answer of the GeoPose Protocol, with the ranges of GeoPose's logical
// model, and nothing that the standard does not name.
const ANSWER = exactly({
  id: { type: 'string' },
  timestamp: { type: 'integer' },
  type: { const: 'geopose' },
  accuracy: exactly({ position: { type: 'number', minimum: 0 },
    orientation: { type: 'number', minimum: 0 } }),
  geopose: exactly({
    position: exactly({
      lat: { type: 'number', minimum: -90, maximum: 90 },
      lon: { type: 'number', minimum: -180, maximum: 180 },
      h: number }),
    quaternion: numbers('x', 'y', 'z', 'w'),
  }),
});

const ajv = new Ajv({ allErrors: true });

// geopose/README.md says where these are from.
const standard = (name) => ajv.compile(JSON.parse(fs.readFileSync(
    new URL(`geopose/${name}.schema.json`, import.meta.url), 'utf8')));
const basicQuaternion = standard('basic_quaternion');
const basicQuaternionStrict = standard('basic_quaternion_strict');
const ours = ajv.compile(ANSWER);

function assertValid(validate, value) {
  assert.ok(validate(value), ajv.errorsText(validate.errors));
}

export function assertValidAnswer(answer) {
  assertValid(ours, answer);
  assertValid(basicQuaternion, answer.geopose);
  assertValid(basicQuaternionStrict, answer.geopose);
}

/**
 * sendRequest() of @oarc/gpp-access, with the answer checked. The schema of
 * requests in that package is of version 1, which its own requests are not.
 */
export async function askGeoPose(url, request) {
  const answer = await sendRequest(url, JSON.stringify(request));
  assertValidAnswer(answer);
  return answer;
}
