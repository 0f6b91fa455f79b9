// What axe-core finds wrong with a page for people who use a keyboard, a screen
// reader or little contrast: WCAG 2.2, level AA.

import assert from 'node:assert/strict';
import fs from 'node:fs';
import path from 'node:path';

const TAGS = ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa',
  'best-practice'];

// work: the folder whose node_modules has axe-core. `exclude`: selectors.
export async function assertAccessible(page, work, exclude = []) {
  await page.evaluate(fs.readFileSync(path.join(work, 'node_modules',
      'axe-core', 'axe.min.js'), 'utf8'));
  const { faults, passes } = await page.evaluate(async ([tags, without]) => {
    const result = await window.axe.run({ exclude: without },
        { runOnly: { type: 'tag', values: tags } });
    return {
      faults: result.violations.flatMap(({ id, help, nodes }) =>
        nodes.map(({ target, failureSummary }) => `${id} (${help}): ` +
            `${target.join(' ')}: ${failureSummary.split('\n').at(-1)}`)),
      passes: result.passes.length,
    };
  }, [TAGS, exclude.map((selector) => [selector])]);
  assert.deepEqual(faults, []);
  // It has looked at something.
  assert.ok(passes > 10, `${passes} rules`);
}
