import assert from 'node:assert/strict';
import test from 'node:test';

import { AgentClient, ApiError } from './client.js';

function answering(status: number, body: string) {
  const asked: { url: string; init: RequestInit | undefined }[] = [];
  const client = new AgentClient(async (url, init) => {
    asked.push({ url, init });
    return new Response(body, { status });
  });
  return { client, asked };
}

test('commands carry what a page of another origin cannot send', async () => {
  const { client, asked } = answering(200, '{"ok":true,"id":3}');
  await client.sendGoal([{ x: 1, y: 2, yaw: 3, level: 0 }]);
  const headers = asked[0].init?.headers as Record<string, string>;
  assert.equal(asked[0].url, 'api/goal');
  assert.equal(asked[0].init?.method, 'POST');
  assert.equal(headers['X-Treeline'], '1');
  assert.equal(headers['Content-Type'], 'application/json');
  assert.deepEqual(JSON.parse(String(asked[0].init?.body)),
      { poses: [{ x: 1, y: 2, yaw: 3, level: 0 }] });
});

test('a refusal is told in the agent\'s own words', async () => {
  const { client } = answering(
      400, '{"error":{"code":"goal_outside","message":"Not on the map."}}');
  await assert.rejects(client.cancel(), (error) =>
    error instanceof ApiError && error.code === 'goal_outside' &&
    error.message === 'Not on the map.');
});

test('a refusal without words is told by its status', async () => {
  for (const body of ['', '<html>', '{}', '{"error":{"message":7}}', 'null']) {
    const { client } = answering(502, body);
    await assert.rejects(client.pause(), /status 502/);
  }
});

test('an agent that is not there is told as such', async () => {
  const client = new AgentClient(async () => {
    throw new TypeError('Failed to fetch');
  });
  await assert.rejects(client.resume(), (error) =>
    error instanceof ApiError && error.code === 'unreachable');
});

test('an agent that does not answer is given up', async () => {
  const client = new AgentClient((_url, init) =>
    new Promise((_resolve, reject) => {
      init?.signal?.addEventListener('abort', () => reject(new Error('abort')));
    }), 1);
  await assert.rejects(client.findYourself(), (error) =>
    error instanceof ApiError && error.code === 'timeout');
});

test('what is not JSON is no information', async () => {
  const { client } = answering(200, 'hello');
  await assert.rejects(client.info(), /not JSON/);
});
