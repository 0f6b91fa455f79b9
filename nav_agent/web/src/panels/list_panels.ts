// Devices and events.

import type { RobotEvent, RobotState } from '../api/types.js';
import { clockOf, plain } from '../model/words.js';
import { card, el, setData, setText } from '../common/dom.js';

const TONES: Record<string, string> = {
  running: 'calm', starting: 'busy', lost: 'bad',
};

export class DevicesPanel {
  readonly element: HTMLElement;
  private readonly list = el('ul', { class: 'devices' });
  private rows = new Map<string, { row: HTMLElement; text: HTMLElement }>();

  constructor() {
    this.element = card('Devices', 'devices', this.list);
  }

  update({ devices }: RobotState): void {
    const names = new Set(devices.map((device) => device.name));
    for (const [name, { row }] of this.rows) {
      if (names.has(name)) continue;
      row.remove();
      this.rows.delete(name);
    }
    for (const { name, state, cause } of devices) {
      let entry = this.rows.get(name);
      if (entry === undefined) {
        const text = el('span', { class: 'detail' });
        const row = el('li', {},
            el('span', { class: 'dot', attributes: { 'aria-hidden': 'true' } }),
            el('span', { class: 'device-name' }, plain(name)), text);
        entry = { row, text };
        this.rows.set(name, entry);
        this.list.append(row);
      }
      setData(entry.row, 'tone', TONES[state] ?? 'warn');
      setText(entry.text, cause === '' ? state : `${state}: ${cause}`);
    }
  }
}

const MOST_EVENTS = 200;

export class EventsPanel {
  readonly element: HTMLElement;
  private readonly list = el('ol', {
    class: 'events',
    attributes: { 'tabindex': '0', 'aria-labelledby': 'events-title' },
  });
  private newest = -1;
  private newestTime = 0;
  // How often the newest line was said, one after the other.
  private said = '';
  private times = 0;

  constructor() {
    this.element = card('Events', 'events', this.list);
    this.clear();
  }

  clear(): void {
    this.newest = -1;
    this.newestTime = 0;
    this.said = '';
    this.list.replaceChildren(
        el('li', { class: 'detail' }, 'Nothing has happened yet.'));
  }

  // Newest first. An agent that began anew counts from the beginning again; one
  // that is asked again repeats itself.
  add(event: RobotEvent): void {
    if (event.number <= this.newest) {
      if (event.time >= this.newestTime - 1e-6 || event.number > 1) return;
      this.clear();
    }
    if (this.newest < 0) this.list.replaceChildren();
    this.newest = event.number;
    this.newestTime = event.time;
    const said = `${event.kind}\n${event.text}`;
    this.times = said === this.said ? this.times + 1 : 1;
    this.said = said;
    if (this.times > 1) this.list.firstElementChild?.remove();
    this.list.prepend(el('li', { attributes: { 'data-kind': event.kind } },
        el('time', {}, clockOf(event.time)),
        el('span', { class: 'kind' }, plain(event.kind)),
        el('span', { class: 'event-text' }, this.times === 1 ? event.text :
            `${event.text} (${this.times} times)`)));
    while (this.list.children.length > MOST_EVENTS) {
      this.list.lastElementChild?.remove();
    }
  }
}
