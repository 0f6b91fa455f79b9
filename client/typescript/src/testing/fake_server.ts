// An HTTP server that speaks Connect and is told what to answer.

import { createServer, type IncomingMessage, type ServerResponse } from
  'node:http';
import type { AddressInfo } from 'node:net';

import type { ConnectRouter } from '@connectrpc/connect';
import { connectNodeAdapter } from '@connectrpc/connect-node';

export interface FakeServer {
  readonly url: string;
  close(): Promise<void>;
}

export type Handler = (request: IncomingMessage, response: ServerResponse) =>
  void;

/** `plain` answers what the routes do not. */
export async function serve(routes: (router: ConnectRouter) => void,
    plain: Handler = (_, response) => response.writeHead(404).end()):
    Promise<FakeServer> {
  const server = createServer(connectNodeAdapter({
    routes,
    // Over HTTP/1.1 it is no other kind of request.
    fallback: (request, response) =>
      plain(request as IncomingMessage, response as ServerResponse),
  }));
  await new Promise<void>((resolve) =>
    server.listen(0, '127.0.0.1', resolve));
  return {
    url: `http://127.0.0.1:${(server.address() as AddressInfo).port}`,
    close: () => new Promise((resolve) => {
      server.close(() => resolve());
      server.closeAllConnections();
    }),
  };
}
