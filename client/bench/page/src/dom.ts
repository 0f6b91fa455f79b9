// Elements without markup, since what a report says only ever becomes text; and
// charts as wide as their place.

export type Child = Node | string | null;

export function el<K extends keyof HTMLElementTagNameMap>(
    tag: K, attributes: Record<string, string> | string = {},
    ...children: Child[]): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  const all = typeof attributes === 'string' ? { class: attributes } :
    attributes;
  for (const [key, value] of Object.entries(all)) {
    element.setAttribute(key, value);
  }
  element.append(...children.filter((child) => child !== null));
  return element;
}

// Drawn again when its width changes: letters keep their size on a phone.
// Colours are the style sheet's, so that light, dark and paper need no drawing.
export function drawing(draw: (width: number) => Element): HTMLElement {
  const element = el('div', 'drawing');
  let drawn = 0;
  const fit = (): void => {
    const width = Math.floor(element.clientWidth);
    if (width === 0 || Math.abs(width - drawn) < 2) return;
    drawn = width;
    element.replaceChildren(draw(width));
  };
  new ResizeObserver(fit).observe(element);
  return element;
}
