// Bundles everything into one file that opens from disk without a network:
//   node src/common/report/build.mjs FOLDER/NAME.html TITLE [DATA.json]
// in a folder with src/main.ts. A report is that file with JSON in the place of
// "@REPORT_DATA@" (common/page/page_template.h). With DATA.json it stands there
// already, and the page may ask the server that it comes from for more.

import { createHash } from 'node:crypto';
import fs from 'node:fs';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { build } from 'esbuild';

const [, , file, title, dataFile] = process.argv;
const folder = path.dirname(file);
const result = await build({
  entryPoints: ['src/main.ts'],
  bundle: true,
  minify: true,
  format: 'iife',
  target: 'es2021',
  charset: 'utf8',
  legalComments: 'none',
  write: false,
  outdir: folder,
});

function output(ending) {
  return result.outputFiles.find((file) => file.path.endsWith(ending)).text;
}

const script = output('.js');
const style = output('.css');
if (/<\/script|<!--/i.test(script) || /<\/style/i.test(style)) {
  throw new Error('the bundle would end its own element');
}
// Only the script of this build runs, and nothing is asked of anybody else.
const hash = createHash('sha256').update(script).digest('base64');
const policy = `default-src 'none'; img-src data:; style-src 'unsafe-inline'; \
script-src 'sha256-${hash}'; base-uri 'none'; form-action 'none'\
${dataFile === undefined ? '' : "; connect-src 'self'"}`;
const parts = { TITLE: title, POLICY: policy, STYLE: style, SCRIPT: script };
const template = fileURLToPath(new URL('template.html', import.meta.url));
const data = '"@REPORT_DATA@"';
let page = fs.readFileSync(template, 'utf8')
    .replace(/@(TITLE|POLICY|STYLE|SCRIPT)@/g, (_, name) => parts[name]);
if (page.split(data).length !== 2) {
  throw new Error('the template must have one place for the data');
}
if (dataFile !== undefined) {
  page = page.split(data).join(
      fs.readFileSync(dataFile, 'utf8').replaceAll('<', '\\u003c'));
}
fs.mkdirSync(folder, { recursive: true });
fs.writeFileSync(file, page);
