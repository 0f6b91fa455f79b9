// The docks that there are, and the making of one.

import type { Dock, Docking, Docks } from '../api/types.js';
import {
  dockDetail, freeDockName, MOST_DOCK_NAME_BYTES,
} from '../model/dock_words.js';
import { button, el, setShown, setText } from '../common/dom.js';

export interface DockCommands {
  // Where the robot stands.
  putHere(name: string, isBackward: boolean): void;
  go(name: string): void;
  out(): void;
  remove(name: string): void;
}

export class DocksPanel {
  readonly element: HTMLElement;
  private readonly list = el('ul', { class: 'obstacles routes' });
  private readonly none = el('p', { class: 'detail' },
      'There are none. Make one where the robot stands, or with the tool on ' +
      'the map.');
  private readonly warning = el('p', { class: 'detail', id: 'docks-warning' });
  private readonly input = el('input', {
    id: 'dock-name', class: 'route-name',
    attributes: {
      'type': 'text', 'maxlength': String(MOST_DOCK_NAME_BYTES),
      'aria-label': 'Name of the dock' },
  });
  private readonly backward = el('input', {
    id: 'dock-backward', attributes: { type: 'checkbox' } });
  private readonly leave = button('Drive out', () => this.commands.out(),
      { class: 'small', id: 'dock-out' });
  private docks: Docks = { revision: 0, docks: [], warning: '' };

  constructor(private readonly commands: DockCommands) {
    this.element = el('details', { class: 'card', id: 'docks' },
        el('summary', {}, 'Docks'),
        el('div', { class: 'needs-link' }, this.none, this.list,
            el('div', { class: 'row dock-row' }, this.input,
                el('label', { class: 'check' }, this.backward, 'Backwards')),
            el('div', { class: 'row' },
                button('Make one here', () => commands.putHere(
                    this.name, this.isBackward),
                { class: 'small', id: 'dock-here', attributes: {
                  title: 'A dock where the robot stands at this moment' } }),
                this.leave),
            this.warning));
    this.update(this.docks, 1);
    this.follow(null);
  }

  // Of the next one that is made.
  get name(): string {
    return this.input.value.trim();
  }

  get isBackward(): boolean {
    return this.backward.checked;
  }

  update(docks: Docks, levels: number): void {
    this.docks = docks;
    this.input.value = freeDockName(docks.docks);
    setShown(this.none, docks.docks.length === 0);
    setText(this.warning, docks.warning);
    setShown(this.warning, docks.warning !== '' && docks.docks.length > 0);
    this.list.replaceChildren(
        ...docks.docks.map((dock) => this.row(dock, levels)));
  }

  private row(dock: Dock, levels: number): HTMLElement {
    const { name } = dock;
    return el('li', {},
        el('span', {}, name),
        el('span', { class: 'detail' }, dockDetail(dock, levels)),
        button('Dock', () => this.commands.go(name), {
          class: 'small', attributes: { 'aria-label': `Dock in ${name}` } }),
        button('Remove', () => this.commands.remove(name), {
          class: 'small', attributes: { 'aria-label': `Remove ${name}` } }));
  }

  // What it says of itself is in *Robot*.
  follow(docking: Docking | null): void {
    setShown(this.leave, docking?.state === 'docked');
  }
}
