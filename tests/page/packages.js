// The packages of the page, and the messages that were generated for it, from
// where `scripts/build-page --check` has put them.

import path from 'node:path';
import { pathToFileURL } from 'node:url';

const work = path.resolve(process.env.TREELINE_PAGE_WORK ?? 'build/page-work');
const fromWork = (...names) =>
  import(pathToFileURL(path.join(work, ...names)).href);

export const connect = await fromWork(
    'node_modules', '@connectrpc', 'connect', 'dist', 'esm', 'index.js');
export const node = await fromWork(
    'node_modules', '@connectrpc', 'connect-node', 'dist', 'esm', 'index.js');
export const messages = await fromWork(
    'unit', 'gen', 'treeline', 'v1', 'navigation_pb.js');
export const dockMessages = await fromWork(
    'unit', 'gen', 'treeline', 'v1', 'docks_pb.js');
export const routeMessages = await fromWork(
    'unit', 'gen', 'treeline', 'v1', 'routes_pb.js');
