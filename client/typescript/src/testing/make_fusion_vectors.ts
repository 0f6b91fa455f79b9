// Writes client/fusion_vectors: node unit/testing/make_fusion_vectors.js FOLDER
// Only where the algorithm was changed on purpose: the files are what other
// implementations are held against.

import { writeFileSync } from 'node:fs';
import { join } from 'node:path';

import { scenarios } from './fusion_scenarios.js';
import { textOf, vectorsOf } from './fusion_vectors.js';

const folder = process.argv[2];
if (folder === undefined) throw new Error('say which folder to write to');
for (const scenario of scenarios()) {
  writeFileSync(
      join(folder, `${scenario.name}.json`), textOf(vectorsOf(scenario)));
}
