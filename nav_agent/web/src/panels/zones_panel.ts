// The zones that there are, and what a zone needs that is being drawn.

import type { Zone, ZoneKind, Zones } from '../api/types.js';
import type { Place } from '../model/gesture.js';
import {
  FASTEST_MPS, freeName, KIND_LABELS, SLOWEST_MPS, zoneDetail, ZoneDraft,
} from '../model/zone_draft.js';
import { button, el, setShown, setText } from '../common/dom.js';

export interface ZoneCommands {
  // Rejects if the agent refuses it.
  put(zone: Zone): Promise<void>;
  remove(name: string): void;
  // The draft has changed: to be drawn.
  drawn(corners: readonly Place[], level: number, kind: ZoneKind): void;
  // The tool is not needed any more.
  done(): void;
}

const FIRST_SPEED_MPS = 0.3;
const HINTS: Record<ZoneKind, string> = {
  'keep-out': 'Click the corners of ground that no part of the robot may touch.',
  'speed': 'Click the corners of ground that it goes slowly on.',
  'one-way': 'Click the corners; the first side shows the way that it may go.',
};

export class ZonesPanel {
  readonly element: HTMLElement;
  // Over the map while one draws.
  readonly bar: HTMLElement;
  private readonly draft = new ZoneDraft();
  private readonly list = el('ul', { class: 'obstacles zones' });
  private readonly none = el('p', { class: 'detail' },
      'There are none. Draw one with the tool on the map.');
  private readonly warning = el('p', { class: 'detail', id: 'zones-warning' });
  private readonly kind = el('select', {
    id: 'zone-kind', attributes: { 'aria-label': 'Kind of zone' },
    on: { change: () => this.show() },
  }, ...Object.entries(KIND_LABELS).map(([value, label]) =>
    el('option', { attributes: { value } }, label)));
  private readonly speed = el('input', {
    id: 'zone-speed',
    attributes: {
      'type': 'number', 'min': String(SLOWEST_MPS),
      'max': String(FASTEST_MPS), 'step': '0.05',
      'aria-label': 'Highest speed in the zone, metres a second' },
  });
  private readonly speedBox = el('label', { class: 'zone-speed' },
      this.speed, el('span', {}, 'm/s'));
  private readonly undo = button('Undo', () => {
    this.draft.undo();
    this.show();
  }, { id: 'zone-undo' });
  private readonly finish = button('Finish', () => this.put(),
      { id: 'zone-finish' });
  private readonly hint = el('p', {
    class: 'zone-hint', attributes: { 'aria-live': 'polite' } });
  private zones: Zones = {
    revision: 0, zones: [], masks: [], warning: '' };
  private levels = 1;
  private isSending = false;

  constructor(private readonly commands: ZoneCommands) {
    this.speed.value = String(FIRST_SPEED_MPS);
    this.bar = el('div', { class: 'zone-bar needs-link', attributes: {
      'role': 'group', 'aria-label': 'Zone that is being drawn' } },
    this.hint,
    el('div', { class: 'row' }, this.kind, this.speedBox, this.undo,
        this.finish));
    this.element = el('details', { class: 'card', id: 'zones' },
        el('summary', {}, 'Zones'),
        el('div', { class: 'needs-link' }, this.none, this.list,
            this.warning));
    this.enable(false);
    this.update(this.zones, 1);
  }

  enable(isOn: boolean): void {
    this.draft.clear();
    setShown(this.bar, isOn);
    this.show();
  }

  addCorner(at: Place, level: number): void {
    this.draft.add(at, level);
    this.show();
  }

  update(zones: Zones, levels: number): void {
    this.zones = zones;
    this.levels = levels;
    setShown(this.none, zones.zones.length + zones.masks.length === 0);
    setText(this.warning, zones.warning);
    setShown(this.warning, zones.warning !== '' && zones.zones.length > 0);
    this.list.replaceChildren(
        ...zones.zones.map((zone) => this.row(zone)),
        ...zones.masks.map((mask) => el('li',
            { attributes: { 'data-zone': mask.kind } },
            el('span', { class: 'swatch',
              attributes: { 'aria-hidden': 'true' } }),
            el('span', {}, mask.name),
            el('span', { class: 'detail' }, 'mask file'))));
  }

  private row(zone: Zone): HTMLElement {
    return el('li', { attributes: { 'data-zone': zone.kind } },
        el('span', { class: 'swatch', attributes: { 'aria-hidden': 'true' } }),
        el('span', {}, zone.name),
        el('span', { class: 'detail' }, zoneDetail(zone, this.levels)),
        button('Remove', () => this.commands.remove(zone.name), {
          class: 'small', attributes: { 'aria-label': `Remove ${zone.name}` },
        }));
  }

  private get chosen(): ZoneKind {
    return this.kind.value as ZoneKind;
  }

  private show(): void {
    const { corners, level } = this.draft;
    setShown(this.speedBox, this.chosen === 'speed');
    this.undo.disabled = corners.length === 0;
    this.finish.disabled = !this.draft.isZone || this.isSending;
    setText(this.hint, corners.length === 0 ? HINTS[this.chosen] :
      this.draft.isZone ? `${corners.length} corners. Finish, or go on.` :
      `${corners.length} of at least 3 corners.`);
    this.commands.drawn(corners, level, this.chosen);
  }

  // What the agent refuses stays, to be mended.
  private async put(): Promise<void> {
    const zone = this.draft.zone(freeName(this.chosen, this.zones.zones),
        this.chosen, Number(this.speed.value));
    this.isSending = true;
    this.show();
    try {
      await this.commands.put(zone);
      this.draft.clear();
      this.commands.done();
    } catch {
      // It was told already.
    } finally {
      this.isSending = false;
      this.show();
    }
  }
}
