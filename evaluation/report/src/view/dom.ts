// Elements without markup: what a report says only ever becomes text.

export type Child = Node | string | null;

export interface Properties {
  class?: string;
  // Whatever else is an attribute.
  attributes?: Record<string, string>;
}

export function el<K extends keyof HTMLElementTagNameMap>(
    tag: K, properties: Properties | string = {}, ...children: Child[]):
    HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  const { class: name, attributes = {} } =
    typeof properties === 'string' ? { class: properties } : properties;
  if (name !== undefined) element.className = name;
  for (const [key, value] of Object.entries(attributes)) {
    element.setAttribute(key, value);
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
