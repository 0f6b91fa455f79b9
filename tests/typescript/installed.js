// The package as a user has it: unpacked into a node_modules of its own, beside
// what it depends on.
import { execFileSync } from 'node:child_process';
import { mkdirSync, mkdtempSync, renameSync, rmSync, symlinkSync } from
  'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';

const { TREELINE_PACKAGE, TREELINE_PACKAGE_WORK } = process.env;

/** Returns its folder, imports by subpath, and what removes it. */
export function install() {
  const root = mkdtempSync(join(tmpdir(), 'treeline-typescript-'));
  const modules = join(root, 'node_modules');
  const folder = join(modules, '@treeline', 'client');
  mkdirSync(join(modules, '@treeline'), { recursive: true });
  execFileSync('tar', ['-xzf', TREELINE_PACKAGE, '-C', root]);
  renameSync(join(root, 'package'), folder);
  for (const scope of ['@bufbuild', '@connectrpc', '@types', 'undici-types']) {
    symlinkSync(join(TREELINE_PACKAGE_WORK, 'node_modules', scope),
      join(modules, scope));
  }
  return {
    root,
    folder,
    load: (file) => import(pathToFileURL(join(folder, 'dist', file)).href),
    remove: () => rmSync(root, { recursive: true }),
  };
}
