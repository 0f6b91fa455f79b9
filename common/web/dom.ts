// Elements without markup: what a server or a report says only ever becomes
// text. Of all our pages; scripts/lib/web.sh copies it to src/common.

export type Child = Node | string | null;
type Listeners = { [K in keyof HTMLElementEventMap]?:
    (event: HTMLElementEventMap[K]) => void };

export interface Properties {
  class?: string;
  id?: string;
  // ARIA and data attributes, and whatever else is an attribute.
  attributes?: Record<string, string>;
  on?: Listeners;
}

// `given` may be a class alone.
export function el<K extends keyof HTMLElementTagNameMap>(
    tag: K, given: Properties | string = {}, ...children: Child[]):
    HTMLElementTagNameMap[K] {
  const properties: Properties =
    typeof given === 'string' ? { class: given } : given;
  const element = document.createElement(tag);
  if (properties.class !== undefined) element.className = properties.class;
  if (properties.id !== undefined) element.id = properties.id;
  for (const [name, value] of Object.entries(properties.attributes ?? {})) {
    element.setAttribute(name, value);
  }
  for (const [name, work] of Object.entries(properties.on ?? {})) {
    element.addEventListener(name, work as EventListener);
  }
  element.append(...children.filter((child) => child !== null));
  return element;
}

export function svg(tag: string, attributes: Record<string, string>):
    SVGElement {
  const element =
    document.createElementNS('http://www.w3.org/2000/svg', tag);
  for (const [key, value] of Object.entries(attributes)) {
    element.setAttribute(key, value);
  }
  return element;
}

// Leaves the page alone where nothing changed: screen readers stay quiet.
export function setText(element: Element, text: string): void {
  if (element.textContent !== text) element.textContent = text;
}

export function setShown(element: HTMLElement, isShown: boolean): void {
  if (element.hidden === isShown) element.hidden = !isShown;
}

export function setData(
    element: HTMLElement, name: string, value: string): void {
  if (element.dataset[name] !== value) element.dataset[name] = value;
}

export function button(
    label: string, work: () => void, properties: Properties = {}):
    HTMLButtonElement {
  return el('button', {
    ...properties,
    attributes: { type: 'button', ...properties.attributes },
    on: { click: work },
  }, label);
}

// A titled part of the side column.
export function card(title: string, id: string, ...children: Child[]):
    HTMLElement {
  const heading = el('h2', { id: `${id}-title` }, title);
  return el('section', {
    class: 'card', id, attributes: { 'aria-labelledby': `${id}-title` },
  }, heading, ...children);
}

// A bar from 0 to 1.
export class Meter {
  readonly element: HTMLElement;
  private readonly bar = el('span', { class: 'meter-bar' });

  constructor(label: string) {
    this.element = el('div', {
      class: 'meter',
      attributes: {
        'role': 'meter', 'aria-label': label,
        'aria-valuemin': '0', 'aria-valuemax': '100',
      },
    }, this.bar);
  }

  set(share: number, tone: string): void {
    const percent = Math.round(100 * Math.max(0, Math.min(1, share)));
    this.bar.style.width = `${percent}%`;
    this.element.setAttribute('aria-valuenow', String(percent));
    setData(this.element, 'tone', tone);
  }
}
