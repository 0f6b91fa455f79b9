// Queries over one connection: LocalizeStream as a WebSocket.

import { create, fromBinary, toBinary } from '@bufbuild/protobuf';
import { ConnectError } from '@connectrpc/connect';

import type { Status } from '../gen/google/rpc/status_pb.js';
import { LocalizeStreamRequestSchema, LocalizeStreamResponseSchema,
  StreamSettingsSchema, type LocalizeRequest, type LocalizeResponse } from
  '../gen/treeline/v1/relocalization_pb.js';
import { TreelineError, treelineErrorOf } from './error.js';
import type { Tools } from './retry.js';

/** What of a browser's WebSocket is used; Node has one from version 22 on. */
export interface Socket {
  binaryType: string;
  readonly readyState: number;
  onopen: ((event: never) => void) | null;
  onmessage: ((event: { data: unknown }) => void) | null;
  onclose: ((event: { code: number, reason: string }) => void) | null;
  send(data: Uint8Array): void;
  close(): void;
}
export type MakeSocket = (url: string, protocols: string[]) => Socket;

const PATH = '/treeline.v1.RelocalizationService/LocalizeStream';
const PROTOCOL = 'treeline.v1';
// A browser sets no headers here: the token goes as a protocol of its own.
const TOKEN_PREFIX = 'treeline.bearer.';
// The trace that all frames belong to, too.
const TRACE_PREFIX = 'treeline.traceparent.';
// What may be the name of a protocol, by RFC 9110.
const IS_TOKEN = /^[\w!#$%&'*+.^`|~-]+$/;
const OPEN = 1;
// A server that does not open a stream is left alone for so long.
const REST_MS = 30_000;

/** There is no stream: the query is to be asked as a call of its own. */
export class NoStream extends Error {
  override readonly name = 'NoStream';
}

interface Waiting {
  readonly resolve: (response: LocalizeResponse) => void;
  readonly reject: (error: Error) => void;
}

// One connection, from its opening to its end.
class Connection {
  private readonly waiting = new Map<bigint, Waiting>();
  private readonly opened: Promise<void>;
  private nextId = 0n;
  private isEnded = false;
  hasOpened = false;
  isUnwanted = false;

  constructor(private readonly socket: Socket, readonly token: string,
      private readonly server: string,
      private readonly onEnd: (connection: Connection) => void) {
    socket.binaryType = 'arraybuffer';
    this.opened = new Promise((resolve, reject) => {
      socket.onopen = () => {
        this.hasOpened = true;
        resolve();
      };
      socket.onclose = ({ code, reason }) => {
        const why = new NoStream(`closed with ${code} ${reason}`);
        reject(why);
        this.end(why);
      };
    });
    // Whoever asks has it told again.
    this.opened.catch(() => {});
    socket.onmessage = ({ data }) => this.onMessage(data);
  }

  async ask(localize: LocalizeRequest, maxPending: number,
      signal: AbortSignal): Promise<LocalizeResponse> {
    await this.opened;
    if (this.socket.readyState !== OPEN) throw new NoStream('closing');
    if (signal.aborted) throw new TreelineError('canceled', 'cancelled');
    const id = this.nextId;
    this.nextId += 1n;
    const message = create(LocalizeStreamRequestSchema, { id, localize });
    if (id === 0n) {
      message.settings = create(StreamSettingsSchema, { maxPending });
    }
    return new Promise<LocalizeResponse>((resolve, reject) => {
      this.waiting.set(id, { resolve, reject });
      // Its answer will come, and nobody will want it.
      signal.addEventListener('abort', () => {
        if (this.waiting.delete(id)) {
          reject(new TreelineError('canceled', 'the call was cancelled'));
        }
      }, { once: true });
      this.socket.send(toBinary(LocalizeStreamRequestSchema, message));
    });
  }

  close(): void {
    this.isUnwanted = true;
    this.socket.close();
    this.end(new NoStream('the stream was closed'));
  }

  private onMessage(data: unknown): void {
    let answer;
    try {
      answer = fromBinary(LocalizeStreamResponseSchema,
          new Uint8Array(data as ArrayBuffer));
    } catch {
      // Whatever it is, it is no server of ours.
      this.socket.close();
      this.end(new NoStream('an answer that is none'));
      return;
    }
    const waiting = this.waiting.get(answer.id);
    this.waiting.delete(answer.id);
    if (waiting === undefined) return;
    const { result } = answer;
    if (result.case === 'response') {
      waiting.resolve(result.value);
    } else if (result.case === 'error') {
      waiting.reject(errorOf(result.value, this.server));
    } else {
      waiting.reject(new TreelineError('internal', 'an empty answer'));
    }
  }

  private end(why: Error): void {
    if (this.isEnded) return;
    this.isEnded = true;
    for (const { reject } of this.waiting.values()) reject(why);
    this.waiting.clear();
    this.onEnd(this);
  }
}

// As the same error of a call.
function errorOf({ code, message, details }: Status, server: string):
    TreelineError {
  const error = new ConnectError(message, code);
  error.details = details.map(({ typeUrl, value }) =>
    ({ type: typeUrl.slice(typeUrl.lastIndexOf('/') + 1), value }));
  return treelineErrorOf(error, server);
}

/**
 * One server's stream, opened with the first query and opened again when it has
 * ended.
 */
export class LocalizeStream {
  private readonly url: string;
  private connection: Connection | null = null;
  private restUntilMs = -Infinity;

  constructor(private readonly server: string,
      private readonly makeSocket: MakeSocket,
      private readonly maxPending: number, private readonly tools: Tools,
      private readonly traceparent: () => string | undefined =
      () => undefined) {
    this.url = server.replace(/^http/, 'ws') + PATH;
  }

  /** Rejects with NoStream where there is none, or with a TreelineError. */
  ask(request: LocalizeRequest, token: string, signal: AbortSignal):
      Promise<LocalizeResponse> {
    // What was opened for another token is not for this one.
    if (this.connection?.token !== token) this.close();
    try {
      this.connection ??= this.open(token);
    } catch (error) {
      return Promise.reject(error);
    }
    return this.connection.ask(request, this.maxPending, signal);
  }

  close(): void {
    this.connection?.close();
  }

  private open(token: string): Connection {
    if (this.tools.nowMs() < this.restUntilMs) throw new NoStream('resting');
    if (token !== '' && !IS_TOKEN.test(token)) {
      throw new NoStream('the token has signs that no protocol has');
    }
    const protocols = token === '' ? [PROTOCOL] :
      [PROTOCOL, TOKEN_PREFIX + token];
    const traceparent = this.traceparent();
    if (traceparent !== undefined) protocols.push(TRACE_PREFIX + traceparent);
    let socket;
    try {
      socket = this.makeSocket(this.url, protocols);
    } catch (error) {
      // A page whose policy forbids it, for instance.
      this.rest();
      throw new NoStream(String(error));
    }
    const opened = new Connection(socket, token, this.server, (connection) => {
      if (this.connection === connection) this.connection = null;
      if (!connection.hasOpened && !connection.isUnwanted) this.rest();
    });
    return opened;
  }

  private rest(): void {
    this.restUntilMs = this.tools.nowMs() + REST_MS;
  }
}

/** Of this browser or Node; null: it has none. */
export const systemSocket = (): MakeSocket | null =>
  globalThis.WebSocket === undefined ? null :
    (url, protocols) =>
      new globalThis.WebSocket(url, protocols) as unknown as Socket;
