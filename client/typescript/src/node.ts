// For Node: TLS with certificates of one's own. Browsers and public
// certificates need only index.ts.

import { readFileSync } from 'node:fs';
import { Agent as HttpAgent, request as httpRequest, type IncomingMessage } from
  'node:http';
import { Agent as HttpsAgent, request as httpsRequest } from 'node:https';

import { TreelineClient, type ClientOptions, type Fetch } from
  './client/treeline_client.js';

export interface TlsFiles {
  /** PEM file of the authorities that the server's certificate is checked
   * against, instead of Node's own. */
  readonly caFile: string;
  /** PEM files of the client's certificate and key, if the server asks. */
  readonly certificateFile?: string;
  readonly keyFile?: string;
}

function bodyOf(message: IncomingMessage): Promise<Uint8Array<ArrayBuffer>> {
  return new Promise((resolve, reject) => {
    const chunks: Uint8Array[] = [];
    message.on('data', (chunk: Uint8Array) => chunks.push(chunk));
    message.on('end', () => resolve(new Uint8Array(Buffer.concat(chunks))));
    message.on('error', reject);
  });
}

async function responseOf(message: IncomingMessage): Promise<Response> {
  const headers = new Headers();
  for (let i = 0; i < message.rawHeaders.length; i += 2) {
    headers.append(message.rawHeaders[i]!, message.rawHeaders[i + 1]!);
  }
  const body = await bodyOf(message);
  // No body may come with some statuses.
  const status = message.statusCode!;
  return new Response(status === 204 || status === 304 ? null : body,
      { status, headers });
}

/**
 * A fetch whose TLS connections are checked with these files, which are read
 * once. Node's own fetch takes no certificates. It takes what TreelineClient
 * sends: bodies of text or bytes, and follows no redirections.
 */
export function fetchWithTls(files: TlsFiles): Fetch {
  const https = new HttpsAgent({
    keepAlive: true,
    ca: readFileSync(files.caFile),
    ...files.certificateFile !== undefined &&
        { cert: readFileSync(files.certificateFile) },
    ...files.keyFile !== undefined && { key: readFileSync(files.keyFile) },
  });
  const http = new HttpAgent({ keepAlive: true });
  return (input, init = {}) => new Promise((resolve, reject) => {
    const url = new URL(input instanceof Request ? input.url : input);
    // As fetch says it: no connection, or it broke.
    const fail = (error: Error) => reject(
        init.signal?.aborted === true ? init.signal.reason :
          new TypeError(error.message, { cause: error }));
    const isTls = url.protocol === 'https:';
    const request = (isTls ? httpsRequest : httpRequest)(url, {
      method: init.method ?? 'GET',
      headers: Object.fromEntries(new Headers(init.headers)),
      agent: isTls ? https : http,
      ...init.signal && { signal: init.signal },
    }, (message) => responseOf(message).then(resolve, fail));
    request.on('error', fail);
    request.end(init.body as string | Uint8Array | null | undefined);
  });
}

/** A TreelineClient whose servers have certificates of the authorities in
 * tls.caFile. */
export const connectWithTls = (
    options: ClientOptions & { readonly tls: TlsFiles }): TreelineClient =>
  new TreelineClient({
    // Node's own trusts other authorities.
    makeSocket: null,
    ...options,
    fetch: fetchWithTls(options.tls),
  });
