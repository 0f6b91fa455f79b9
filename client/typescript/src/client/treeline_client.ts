// The client of treeline-server.

import { create } from '@bufbuild/protobuf';
import { createClient, type CallOptions as ConnectOptions, type Transport } from
  '@connectrpc/connect';
import { createConnectTransport } from '@connectrpc/connect-web';

import type { Fix } from '../fusion/drift_corrector.js';
import { LocalizeOptionsSchema, RelocalizationService } from
  '../gen/treeline/v1/relocalization_pb.js';
import { SceneService } from '../gen/treeline/v1/scenes_pb.js';
import { answerOf, recentQueryOf, requestOf, sceneMapOf, sceneOf } from
  './convert.js';
import { TreelineError, treelineErrorOf } from './error.js';
import { geoPoseAnswerOf, geoPoseErrorOf, geoPoseRequestOf,
  type GeoPoseAnswer, type GeoPoseQuery } from './geo_pose.js';
import { LocalizeStream, NoStream, systemSocket, type MakeSocket } from
  './localize_stream.js';
import { localizeLatest, type LatestOptions, type TimedAnswer,
  type TimedQuery } from './localize_latest.js';
import { callWithRetries, DEFAULT_RETRY, Replicas, SYSTEM_TOOLS, type Attempt,
  type RetryPolicy, type Tools } from './retry.js';
import { isTraceparent } from './traceparent.js';
import type { LocalizeAnswer, LocalizeQuery, RecentQuery, Scene, SceneMap,
  SceneMapOptions } from './types.js';

/** The fetch of browsers and Node, or one like it. */
export type Fetch = typeof globalThis.fetch;

export interface ClientOptions {
  /**
   * Base URL of the server's HTTP port: "https://treeline.example.com". Several
   * are replicas with the same scenes: the one that answered last is kept to,
   * and the others take over when it does not.
   */
  readonly servers: string | readonly string[];
  /** A bearer token, or what gives one; asked before each attempt. */
  readonly token?: string | (() => string | Promise<string>);
  /** Of a call, retries included. */
  readonly timeoutMs?: number;
  /** Of one attempt, where there are several servers; default: half of
   * timeoutMs, so that one that hangs does not take all the time. */
  readonly attemptTimeoutMs?: number;
  readonly retry?: Partial<RetryPolicy>;
  /** Names the scene in the header X-Treeline-Scene too, so that a balancer can
   * choose the server by it. Not of localizeLatest() over a WebSocket. Pages of
   * another origin need servers that allow the header, as those of this version
   * do. Default: false. */
  readonly sceneHeader?: boolean;
  /** Gives the span that a call belongs to, as W3C has it, whose child the
   * server's becomes; asked before each attempt. newTraceparent() makes one.
   * What is none is left out. */
  readonly traceparent?: () => string | undefined;
  readonly fetch?: Fetch;
  /** Opens WebSockets for localizeLatest(); null: it makes calls. Default: the
   * one of this browser or Node, which has one from version 22 on. */
  readonly makeSocket?: MakeSocket | null;
  /** Clock and chance; for tests. */
  readonly tools?: Tools;
}

export interface CallOptions {
  readonly timeoutMs?: number;
  /** Cancels the call, here and on the server. */
  readonly signal?: AbortSignal;
}

/** One server's word on itself. */
export interface ServerHealth {
  readonly server: string;
  readonly reachable: boolean;
  /** Whether it answers queries. */
  readonly ready: boolean;
  /** What it says, or why it cannot be reached. */
  readonly detail: string;
}

const DEFAULT_TIMEOUT_MS = 10_000;
const IS_SCENE_NAME = /^[\w.-]{1,128}$/;

type Streams = ReadonlyMap<string, LocalizeStream>;

interface Server {
  readonly localize:
      (request: Awaited<ReturnType<typeof requestOf>>, options: ConnectOptions)
      => Promise<Parameters<typeof answerOf>[0]>;
  readonly listScenes:
      (options: ConnectOptions) => Promise<readonly Scene[]>;
  readonly getScene:
      (scene: string, options: ConnectOptions) => Promise<Scene>;
  readonly sceneMap: (scene: string, want: SceneMapOptions,
      options: ConnectOptions) => Promise<SceneMap>;
  readonly recentQueries: (scene: string, options: ConnectOptions) =>
      Promise<readonly RecentQuery[]>;
}

function serverOver(transport: Transport): Server {
  const relocalization = createClient(RelocalizationService, transport);
  const scenes = createClient(SceneService, transport);
  return {
    localize: (request, options) => relocalization.localize(request, options),
    listScenes: async (options) =>
      (await scenes.listScenes({}, options)).scenes.map(sceneOf),
    getScene: async (scene, options) => {
      const { scene: info } = await scenes.getScene({ scene }, options);
      if (info === undefined) {
        throw new TreelineError('internal', 'the server sent no scene');
      }
      return sceneOf(info);
    },
    sceneMap: async (scene, { maxPoints = 0, wantsCoverage = false }, options) =>
      sceneMapOf(await scenes.getSceneMap(
          { scene, maxPoints, includeCoverage: wantsCoverage }, options)),
    recentQueries: async (scene, options) =>
      (await scenes.listRecentQueries({ scene }, options)).queries
          .map(recentQueryOf),
  };
}

// Without a slash at the end. Throws a TypeError for what is no URL.
function baseUrlOf(server: string): string {
  const url = new URL(server);
  if (url.protocol !== 'http:' && url.protocol !== 'https:') {
    throw new TypeError(`${server}: is not a URL of http or https`);
  }
  return url.href.replace(/\/+$/, '');
}

/**
 * Asks treeline-server where a camera is. All methods reject with a
 * TreelineError. Calls may run side by side.
 */
export class TreelineClient {
  private readonly servers = new Map<string, Server>();
  private readonly replicas: Replicas;
  private readonly token: () => string | Promise<string>;
  private readonly timeoutMs: number;
  private readonly attemptTimeoutMs: number | undefined;
  private readonly policy: RetryPolicy;
  private readonly sceneHeader: boolean;
  private readonly traceparent: () => string | undefined;
  private readonly fetch: Fetch;
  private readonly tools: Tools;
  private readonly makeSocket: MakeSocket | null;

  /** Throws a TypeError for what is no URL, and for no server at all. */
  constructor(options: ClientOptions) {
    const given = typeof options.servers === 'string' ? [options.servers] :
      options.servers;
    const urls = [...new Set(given.map(baseUrlOf))];
    if (urls.length === 0) throw new TypeError('servers: there is none');
    const { token = '' } = options;
    this.token = typeof token === 'string' ? () => token : token;
    this.timeoutMs = options.timeoutMs ?? DEFAULT_TIMEOUT_MS;
    this.attemptTimeoutMs = options.attemptTimeoutMs;
    this.policy = { ...DEFAULT_RETRY, ...options.retry };
    this.sceneHeader = options.sceneHeader ?? false;
    this.traceparent = options.traceparent ?? (() => undefined);
    // A browser's fetch wants to be called as a method of its window.
    this.fetch = options.fetch ?? ((...args) => globalThis.fetch(...args));
    this.tools = options.tools ?? SYSTEM_TOOLS;
    this.makeSocket = options.makeSocket === undefined ? systemSocket() :
      options.makeSocket;
    this.replicas = new Replicas(urls);
    for (const baseUrl of urls) {
      this.servers.set(baseUrl, serverOver(createConnectTransport(
          { baseUrl, useBinaryFormat: true, fetch: this.fetch })));
    }
  }

  /**
   * Where one picture was taken. "Not localized" is an answer, not an error.
   * The answer's worldFromCamera maps the camera's frame (x right, y down, z
   * forward of the picture as it is sent) into the scene's world.
   */
  localize(query: LocalizeQuery, options: CallOptions = {}):
      Promise<LocalizeAnswer> {
    return this.localizeOver(null, query, options);
  }

  /**
   * Localizes the newest picture of a camera, again and again: at most
   * maxInFlight at a time; a newer picture replaces one that waits. Pictures go
   * over one WebSocket, where there can be one, else each is a call.
   */
  async* localizeLatest(source: AsyncIterable<TimedQuery>,
      options: LatestOptions = {}): AsyncGenerator<TimedAnswer, void, void> {
    const streams = this.streams(options);
    try {
      yield* localizeLatest(
          (query, call) => this.localizeOver(streams, query, call), source,
          options);
    } finally {
      for (const stream of streams?.values() ?? []) stream.close();
    }
  }

  /** Every scene that this token may see, by name. */
  scenes(options: CallOptions = {}): Promise<readonly Scene[]> {
    return this.call(options, (server, connect) => server.listScenes(connect));
  }

  /** One scene; rejects with `not_found` if there is no such scene. */
  scene(name: string, options: CallOptions = {}): Promise<Scene> {
    return this.call(options,
        (server, connect) => server.getScene(name, connect), name);
  }

  /** Points, keyframes and coverage of a scene. Rejects with
   * `failed_precondition` where its model has no keyframes. */
  sceneMap(name: string, want: SceneMapOptions = {}, options: CallOptions = {}):
      Promise<SceneMap> {
    return this.call(options, (server, connect) =>
      server.sceneMap(name, want, connect), name);
  }

  /** What became of the latest queries in a scene, the newest first. Rejects
   * with `failed_precondition` where the server keeps none. */
  recentQueries(name: string, options: CallOptions = {}):
      Promise<readonly RecentQuery[]> {
    return this.call(options, (server, connect) =>
      server.recentQueries(name, connect), name);
  }

  /**
   * Where one picture was taken on the Earth, by the GeoPose Protocol. Rejects
   * with `not_found` where it is not localized: the protocol has no such
   * answer.
   */
  async geoPose(query: GeoPoseQuery, options: CallOptions = {}):
      Promise<GeoPoseAnswer> {
    const body = JSON.stringify(await geoPoseRequestOf(query));
    return this.attempt(options, async ({ server, signal }) => {
      const response = await this.fetch(`${server}/geopose`, {
        method: 'POST',
        headers: {
          ...await this.authorization(),
          ...this.traced(),
          'Content-Type': 'application/json',
          'Accept': 'application/vnd.oscp+json;version=2.0',
        },
        body,
        signal,
      });
      if (!response.ok) throw await geoPoseErrorOf(response);
      return geoPoseAnswerOf(await response.json());
    });
  }

  /** Whether each server is there and answers queries. Rejects only if the
   * call is cancelled. */
  health(options: CallOptions = {}): Promise<readonly ServerHealth[]> {
    return Promise.all([...this.servers.keys()].map((server) =>
      this.healthOf(server, options)));
  }

  private streams({ transport = 'auto', maxInFlight = 1 }: LatestOptions):
      Streams | null {
    const { makeSocket } = this;
    if (makeSocket === null || transport === 'calls') return null;
    const maxPending = Math.min(64, Math.max(4, maxInFlight));
    return new Map([...this.servers.keys()].map((server) => [server,
      new LocalizeStream(server, makeSocket, maxPending, this.tools,
          () => this.traced().traceparent)]));
  }

  private async localizeOver(streams: Streams | null, query: LocalizeQuery,
      options: CallOptions): Promise<LocalizeAnswer> {
    const startMs = this.tools.nowMs();
    const request = await requestOf(query);
    const response = await this.attempt(options, async (attempt) => {
      const answer = await this.askStream(
          streams?.get(attempt.server), request, attempt);
      return answer ?? this.servers.get(attempt.server)!.localize(
          request, await this.connectOptions(attempt, query.scene));
    });
    return answerOf(response, this.tools.nowMs() - startMs);
  }

  // null: there is no stream, or it has broken.
  private async askStream(stream: LocalizeStream | undefined,
      request: Awaited<ReturnType<typeof requestOf>>,
      { timeoutMs, signal }: Attempt) {
    if (stream === undefined) return null;
    const { options } = request;
    // Its deadline; a call has it in a header.
    const timeBudgetMs =
        Math.min(options?.timeBudgetMs ?? Infinity, Math.max(1, timeoutMs));
    try {
      return await stream.ask({ ...request, options: create(
          LocalizeOptionsSchema, { ...options, timeBudgetMs }) },
      await this.bearer(), signal);
    } catch (error) {
      if (error instanceof NoStream) return null;
      throw error;
    }
  }

  private async healthOf(server: string, options: CallOptions):
      Promise<ServerHealth> {
    try {
      return await callWithRetries(async ({ signal }) => {
        const response = await this.fetch(`${server}/readyz`, { signal });
        const detail = (await response.text()).trim();
        return { server, reachable: true, ready: response.ok, detail };
      }, new Replicas([server]), { ...this.policy, maxAttempts: 1 },
      this.limits(options), this.tools);
    } catch (caught) {
      const error = treelineErrorOf(caught, server);
      if (error.code === 'canceled') throw error;
      return { server, reachable: false, ready: false, detail: error.message };
    }
  }

  private call<T>(options: CallOptions,
      ask: (server: Server, options: ConnectOptions) => Promise<T>,
      scene?: string): Promise<T> {
    return this.attempt(options, async (attempt) => ask(
        this.servers.get(attempt.server)!,
        await this.connectOptions(attempt, scene)));
  }

  private async connectOptions({ timeoutMs, signal }: Attempt,
      scene: string | undefined): Promise<ConnectOptions> {
    return {
      // The protocol has whole milliseconds, and none of 0.
      timeoutMs: Math.max(1, Math.floor(timeoutMs)),
      signal,
      headers: { ...await this.authorization(), ...this.sceneNamed(scene),
        ...this.traced() },
    };
  }

  private attempt<T>(options: CallOptions,
      ask: (attempt: Attempt) => Promise<T>): Promise<T> {
    return callWithRetries(async (attempt) => {
      try {
        return await ask(attempt);
      } catch (error) {
        throw treelineErrorOf(error, attempt.server);
      }
    }, this.replicas, this.policy, this.limits(options), this.tools);
  }

  private limits({ timeoutMs = this.timeoutMs, signal }: CallOptions) {
    return { timeoutMs, signal,
      attemptTimeoutMs: this.attemptTimeoutMs ?? timeoutMs / 2 };
  }

  private async bearer(): Promise<string> {
    try {
      return await this.token();
    } catch (error) {
      throw new TreelineError('unauthenticated',
          'the provider of tokens has none', '', {}, null, { cause: error });
    }
  }

  // What is no name goes in the request alone, which the server answers; fetch
  // would refuse some as a header.
  private sceneNamed(scene = ''): Record<string, string> {
    return this.sceneHeader && IS_SCENE_NAME.test(scene) ?
      { 'X-Treeline-Scene': scene } : {};
  }

  private traced(): { traceparent?: string } {
    const traceparent = this.traceparent();
    return traceparent !== undefined && isTraceparent(traceparent) ?
      { traceparent } : {};
  }

  private async authorization(): Promise<Record<string, string>> {
    const token = await this.bearer();
    return token === '' ? {} : { Authorization: `Bearer ${token}` };
  }
}

/** What DriftCorrector takes of an answer; null if it was not localized. */
export const fixOf = (
    answer: LocalizeAnswer, captureTimeMs: number): Fix | null =>
  answer.localized ? {
    captureTimeMs,
    worldFromCamera: answer.worldFromCamera,
    covariance: answer.covariance,
    confidence: answer.confidence,
  } : null;
