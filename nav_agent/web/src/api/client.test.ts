import assert from 'node:assert/strict';
import test from 'node:test';

import { Code, ConnectError, createRouterTransport,
  type ServiceImpl } from '@connectrpc/connect';

import { NavigationService, type NavigateRequest } from
  '../gen/treeline/v1/navigation_pb.js';
import { AgentClient, ApiError } from './client.js';

const noFetch = async () => {
  throw new Error('nothing is fetched here');
};

function answering(
    service: Partial<ServiceImpl<typeof NavigationService>>, timeoutMs = 8000) {
  return new AgentClient(createRouterTransport(
      ({ service: add }) => void add(NavigationService, service)),
  noFetch, timeoutMs);
}

function fetching(status: number, body: string) {
  const none = createRouterTransport(() => {});
  return new AgentClient(none, async () => new Response(body, { status }));
}

const isApiError = (code: string, message?: RegExp) => (error: unknown) =>
  error instanceof ApiError && error.code === code &&
  (message === undefined || message.test(error.message));

test('a goal stays when the page stops to listen', async () => {
  const asked: NavigateRequest[] = [];
  let hungUp: (() => void) | undefined;
  const isOver = new Promise<void>((resolve) => { hungUp = resolve; });
  await answering({
    async* navigate(request, { signal }) {
      asked.push(request);
      signal.addEventListener('abort', () => hungUp?.());
      yield {};
      await isOver;
    },
  }).sendGoal([{ x: 1, y: 2, yaw: 3, level: 0 }]);
  assert.equal(asked[0].keepWhenCallEnds, true);
  assert.equal(asked[0].poses[0].xM, 1);
  assert.equal(asked[0].poses[0].yawRad, 3);
  // Else this waits for ever.
  await isOver;
});

test('a refusal is told in the agent\'s own words', async () => {
  const refusing = answering({
    cancel() {
      throw new ConnectError('Not on the map.', Code.InvalidArgument);
    },
    async* navigate() {
      throw new ConnectError('No pose.', Code.InvalidArgument);
    },
    pause() {
      throw new ConnectError('', Code.FailedPrecondition);
    },
  });
  await assert.rejects(
      refusing.cancel(), isApiError('invalid_argument', /^Not on the map.$/));
  await assert.rejects(
      refusing.sendGoal([]), isApiError('invalid_argument', /^No pose.$/));
  await assert.rejects(refusing.pause(),
      isApiError('failed_precondition', /"failed precondition"/));
});

test('an agent that is not there is told as such', async () => {
  const gone = answering({
    resume() {
      throw new TypeError('Failed to fetch');
    },
  });
  await assert.rejects(gone.resume(), ApiError);
  const away = new AgentClient(createRouterTransport(() => {}), async () => {
    throw new TypeError('Failed to fetch');
  });
  await assert.rejects(away.bytes('api/octomap'), isApiError('unreachable'));
});

test('an agent that does not answer is given up', async () => {
  await assert.rejects(
      answering({ findYourself: () => new Promise(() => {}) }, 1)
          .findYourself(), isApiError('timeout'));
  const silent = new AgentClient(createRouterTransport(() => {}),
      (_url, init) => new Promise((_resolve, reject) => {
        init?.signal?.addEventListener(
            'abort', () => reject(new Error('abort')));
      }), 1);
  await assert.rejects(silent.picture('api/camera.jpg'), isApiError('timeout'));
});

test('a method that the agent does not have is told', async () => {
  await assert.rejects(answering({}).info(), isApiError('unimplemented'));
});

test('a file that is refused is told in the agent\'s own words', async () => {
  await assert.rejects(
      fetching(404, '{"error":{"code":"not_found","message":"No level."}}')
          .bytes('api/levels/9.heights'), isApiError('not_found', /No level/));
});

test('a refusal without words is told by its status', async () => {
  for (const body of ['', '<html>', '{}', '{"error":{"message":7}}', 'null']) {
    await assert.rejects(
        fetching(502, body).picture('api/camera.jpg'), /status 502/);
  }
});
