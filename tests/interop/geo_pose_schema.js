// What GeoPose answers must be, checked by ajv.
import assert from 'node:assert/strict';

import { sendRequest } from '@oarc/gpp-access';
import Ajv from 'ajv';

const number = { type: 'number' };
// All members are needed, and there are no others.
const exactly = (properties) => ({ type: 'object', properties,
  required: Object.keys(properties), additionalProperties: false });
const numbers = (...names) =>
  exactly(Object.fromEntries(names.map((name) => [name, number])));

// What GeoPose.Basic.Quaternion of OGC GeoPose 1.0 (21-056r11, with the schemas
// of schemas.opengis.net/geopose/1.0) demands, in our words, with the ranges of
// its logical model; and the answer of the GeoPose Protocol around it.
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
const validate = ajv.compile(ANSWER);

export const assertValidAnswer = (answer) =>
  assert.ok(validate(answer), ajv.errorsText(validate.errors));

/**
 * sendRequest() of @oarc/gpp-access, with the answer checked. The schema of
 * requests in that package is of version 1, which its own requests are not.
 */
export async function askGeoPose(url, request) {
  const answer = await sendRequest(url, JSON.stringify(request));
  assertValidAnswer(answer);
  return answer;
}
