// What of a page cannot be seen, touched or reached, as a person on a phone
// would find it. Each function gives a list of faults in words.

// Runs in the page. Texts that are cut off or lie over each other, scrolling to
// the side, and what is touched: its size, and whether something covers it.
// `minTargetPx`: least side of what is touched. `mayScroll`: a selector of what
// may be wider than the page, and scrolls by itself.
function findLayoutFaults([minTargetPx, mayScroll]) {
  const faults = [];
  // Not the window's: a phone shows a page that is too wide smaller.
  const pageWidth = document.documentElement.clientWidth;
  const nameOf = (part) => part.id ? `#${part.id}` :
    `${part.tagName.toLowerCase()} '${
      (part.ariaLabel || part.textContent).trim().slice(0, 40)}'`;
  const isSeen = (part) => part.checkVisibility({ visibilityProperty: true });
  const meet = (a, b) => ({ left: Math.max(a.left, b.left),
    top: Math.max(a.top, b.top), right: Math.min(a.right, b.right),
    bottom: Math.min(a.bottom, b.bottom) });
  const isArea = (box) => box.right - box.left > 1 && box.bottom - box.top > 1;
  const ancestorsOf = (part) => part.parentElement === null ? [] :
    [part.parentElement, ...ancestorsOf(part.parentElement)];

  for (const part of [document.documentElement,
    ...document.querySelectorAll('body *')]) {
    const { overflowX } = getComputedStyle(part);
    const isRoot = part === document.documentElement;
    const scrolls = isRoot ? part.scrollWidth > pageWidth :
      ['auto', 'scroll'].includes(overflowX) &&
        part.scrollWidth > part.clientWidth + 1;
    if (scrolls && !part.matches(mayScroll)) {
      faults.push(`${isRoot ? 'the page' : nameOf(part)} scrolls to the side`);
    }
  }

  // Words of their own, and where they are.
  const texts = [];
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walker.nextNode()) {
    const { currentNode: node } = walker;
    const part = node.parentElement;
    if (node.data.trim() === '' || !isSeen(part) ||
        part.closest('option, noscript, script, style, .hidden-label')) {
      continue;
    }
    const range = document.createRange();
    range.selectNodeContents(node);
    texts.push({ part, text: node.data.trim(), box: range.getBoundingClientRect() });
  }
  for (const { part, text, box } of texts) {
    const wide = ancestorsOf(part).some((each) => each.matches(mayScroll)) ||
        part.matches(mayScroll);
    for (const each of [part, ...ancestorsOf(part)]) {
      const { overflowX, overflowY } = getComputedStyle(each);
      const clip = each.getBoundingClientRect();
      if (each === document.body || each === document.documentElement) continue;
      if (overflowX !== 'visible' && !wide &&
          (box.left < clip.left - 1 || box.right > clip.right + 1)) {
        faults.push(`'${text}' is cut off at the side by ${nameOf(each)}`);
      }
      if (['hidden', 'clip'].includes(overflowY) &&
          (box.top < clip.top - 1 || box.bottom > clip.bottom + 1)) {
        faults.push(`'${text}' is cut off by ${nameOf(each)}`);
      }
    }
    if (!wide && (box.left < -1 || box.right > pageWidth + 1)) {
      faults.push(`'${text}' is beside the page`);
    }
  }
  // What is seen of each, now.
  const shown = texts.map((each) => ({ ...each,
    box: [each.part, ...ancestorsOf(each.part)].reduce((box, ancestor) =>
      getComputedStyle(ancestor).overflow === 'visible' ? box :
        meet(box, ancestor.getBoundingClientRect()), each.box) }))
      .filter(({ box }) => isArea(box));
  for (const [i, a] of shown.entries()) {
    for (const b of shown.slice(i + 1)) {
      if (a.part.contains(b.part) || b.part.contains(a.part)) continue;
      if (isArea(meet(a.box, b.box))) {
        faults.push(`'${a.text}' and '${b.text}' lie over each other`);
      }
    }
  }

  for (const part of document.querySelectorAll('a[href], button, select, ' +
      'summary, input, textarea, [tabindex="0"]')) {
    if (!isSeen(part) || part.disabled) continue;
    const target = part.matches('input[type=checkbox]') ?
      part.closest('label') ?? part : part;
    target.scrollIntoView({ block: 'nearest' });
    const box = target.getBoundingClientRect();
    if (box.width < minTargetPx || box.height < minTargetPx) {
      faults.push(`${nameOf(part)} is ${box.width.toFixed(0)} x ` +
          `${box.height.toFixed(0)} px to touch`);
    }
    const top = document.elementFromPoint(box.left + box.width / 2,
        box.top + box.height / 2);
    if (top === null || !(target.contains(top) || part === top)) {
      faults.push(`${nameOf(part)} is covered by ` +
          `${top === null ? 'nothing: it is outside' : nameOf(top)}`);
    }
  }
  return [...new Set(faults)];
}

export const layoutFaults =
    (page, { minTargetPx = 44, mayScroll = 'none' } = {}) =>
      page.evaluate(findLayoutFaults, [minTargetPx, mayScroll]);

// Runs in the page: what the keyboard is at, and what is wrong with it.
function lookAtFocus() {
  const part = document.activeElement;
  if (part === null || part === document.body) return null;
  const all = [...document.querySelectorAll('*')];
  const { outlineStyle, outlineWidth, outlineColor } = getComputedStyle(part);
  const target = part.matches('input[type=checkbox]') ?
    part.closest('label') ?? part : part;
  const box = part.getBoundingClientRect();
  const top = document.elementFromPoint(
      box.left + box.width / 2, box.top + box.height / 2);
  const name = part.id || part.ariaLabel || part.textContent.trim();
  const faults = [];
  if (outlineStyle === 'none' || Number.parseFloat(outlineWidth) < 2 ||
      outlineColor === 'rgba(0, 0, 0, 0)') {
    faults.push(`${name}: the focus is not visible`);
  }
  if (box.right <= 0 || box.bottom <= 0 || box.left >= window.innerWidth ||
      box.top >= window.innerHeight || top === null ||
      !(target.contains(top) || part.contains(top))) {
    faults.push(`${name}: it has the focus where it is not seen`);
  }
  return { at: all.indexOf(part), name, faults };
}

// Presses Tab from the beginning to the end. The names of what it came to, in
// their order, and the faults.
export async function walkByKeyboard(page) {
  await page.evaluate(() => {
    document.activeElement?.blur();
    window.getSelection()?.removeAllRanges();
    document.body.tabIndex = -1;
    document.body.focus();
    document.body.removeAttribute('tabindex');
  });
  const names = [];
  const faults = [];
  let last = -1;
  for (let i = 0; i < 200; ++i) {
    await page.keyboard.press('Tab');
    const seen = await page.evaluate(lookAtFocus);
    if (seen === null || seen.at <= last) break;
    last = seen.at;
    names.push(seen.name);
    faults.push(...seen.faults);
  }
  const wanted = await page.evaluate(() => [...document.querySelectorAll(
      'a[href], button, select, summary, input, textarea, [tabindex="0"]')]
      .filter((part) => part.checkVisibility({ visibilityProperty: true }) &&
          !part.disabled)
      .map((part) => part.id || part.ariaLabel || part.textContent.trim()));
  for (const name of wanted) {
    if (!names.includes(name)) faults.push(`${name}: Tab does not come to it`);
  }
  return { names, faults };
}

// What a screen reader would find without a name.
export async function nameFaults(page) {
  const session = await page.context().newCDPSession(page);
  const { nodes } = await session.send('Accessibility.getFullAXTree');
  await session.detach();
  const isFocusable = ({ properties = [] }) => properties.some(
      ({ name, value }) => name === 'focusable' && value.value === true);
  return nodes.filter((node) => !node.ignored && isFocusable(node) &&
      node.role.value !== 'RootWebArea' && !node.name?.value?.trim())
      .map(({ role }) => `a ${role.value} has no name`);
}
