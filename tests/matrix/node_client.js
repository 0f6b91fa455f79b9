// Answers a query a line with @treeline/client in Node:
//   node node_client.js    with TREELINE_PACKAGE and TREELINE_PACKAGE_WORK
import { createInterface } from 'node:readline';

import { install } from '../typescript/installed.js';
import { ask } from './ask.js';

const installed = install();
const library = await installed.load('index.js');
for await (const line of createInterface({ input: process.stdin })) {
  console.log(JSON.stringify(await ask(library, JSON.parse(line))));
}
installed.remove();
