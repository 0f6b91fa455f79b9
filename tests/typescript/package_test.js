// What is in the package of @treeline/client. Run by ctest.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { existsSync, readFileSync, writeFileSync } from 'node:fs';
import { dirname, join, resolve } from 'node:path';
import { after, test } from 'node:test';

import { install } from './installed.js';

const { TREELINE_PACKAGE, TREELINE_PACKAGE_WORK, TREELINE_ROOT } = process.env;
const installed = install();
after(() => installed.remove());

const files = execFileSync('tar', ['-tzf', TREELINE_PACKAGE],
  { encoding: 'utf8' }).trim().split('\n')
  .map((name) => name.replace(/^package\//, ''));

test('the package has what users need, and nothing else', () => {
  for (const name of ['LICENSE', 'README.md', 'package.json', 'dist/index.js',
    'dist/index.d.ts', 'dist/node.js', 'dist/node.d.ts',
    'dist/gen/treeline/v1/relocalization_pb.js']) {
    assert.ok(files.includes(name), `${name} is missing`);
  }
  const strange = files.filter((name) =>
    !['LICENSE', 'README.md', 'package.json'].includes(name) &&
    !/^dist\/[\w/]+(\.js|\.d\.ts)$/.test(name));
  assert.deepEqual(strange, []);
  assert.deepEqual(
    files.filter((name) => /\.test\.|^dist\/testing\//.test(name)), []);
  // Each module has its types.
  for (const name of files.filter((file) => file.endsWith('.js'))) {
    assert.ok(files.includes(name.replace(/\.js$/, '.d.ts')), name);
  }
});

// What a module of the package imports, in it and beside it.
function importsOf(path, seen = new Map()) {
  if (seen.has(path)) return seen;
  const names = [...readFileSync(path, 'utf8')
    .matchAll(/(?:from|import)\s+['"]([^'"]+)['"]/g)].map((match) => match[1]);
  seen.set(path, names);
  for (const name of names.filter((other) => other.startsWith('.'))) {
    importsOf(resolve(dirname(path), name), seen);
  }
  return seen;
}

test('nothing that browsers load needs Node', () => {
  const imported = importsOf(join(installed.folder, 'dist', 'index.js'));
  assert.ok(imported.size > 15);
  const outside = new Set([...imported.values()].flat()
    .filter((name) => !name.startsWith('.')));
  assert.deepEqual([...outside].sort(), ['@bufbuild/protobuf',
    '@bufbuild/protobuf/codegenv2', '@bufbuild/protobuf/wkt',
    '@connectrpc/connect', '@connectrpc/connect-web']);
});

test('what the package imports it depends on', () => {
  const { dependencies } = JSON.parse(
    readFileSync(join(installed.folder, 'package.json'), 'utf8'));
  assert.deepEqual(Object.keys(dependencies).sort(), ['@bufbuild/protobuf',
    '@connectrpc/connect', '@connectrpc/connect-web']);
});

test('both entries are found by their names', () => {
  const script = `
    import { TreelineClient, DriftCorrector } from '@treeline/client';
    import { connectWithTls } from '@treeline/client/node';
    console.log(typeof TreelineClient, typeof DriftCorrector,
      typeof connectWithTls);`;
  writeFileSync(join(installed.root, 'entries.mjs'), script);
  assert.equal(execFileSync(process.execPath,
    [join(installed.root, 'entries.mjs')], { encoding: 'utf8' }),
  'function function function\n');
});

test('the examples of the pages are right, by the types', () => {
  const examples = [];
  for (const page of ['client/typescript/README.md',
    'docs/how-to/use-from-typescript.md']) {
    const text = readFileSync(join(TREELINE_ROOT, page), 'utf8');
    for (const [, code] of text.matchAll(/```ts\n([\s\S]*?)```/g)) {
      const file = `example-${examples.length}.ts`;
      writeFileSync(join(installed.root, file), `${code}\nexport {};\n`);
      examples.push(file);
    }
  }
  assert.ok(examples.length >= 4);
  writeFileSync(join(installed.root, 'package.json'), '{"type": "module"}');
  writeFileSync(join(installed.root, 'tsconfig.json'), JSON.stringify({
    compilerOptions: { target: 'ES2022', module: 'NodeNext', strict: true,
      lib: ['ES2022', 'DOM', 'DOM.Iterable'], types: ['node'], noEmit: true,
      skipLibCheck: true, preserveSymlinks: true },
    files: examples,
  }));
  const compiler = join(TREELINE_PACKAGE_WORK, 'node_modules', '.bin', 'tsc');
  assert.ok(existsSync(compiler));
  try {
    execFileSync(compiler, ['-p', installed.root],
      { encoding: 'utf8', cwd: installed.root });
  } catch (error) {
    assert.fail(error.stdout);
  }
});
