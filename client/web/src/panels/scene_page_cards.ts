// The side column of the scene page.

import type { RecentQuery, Scene, SceneMap } from '@treeline/client';

import { countQueries, describeMap, percentOf } from
  '../model/scene_picture.js';
import { reasonInWords, type Saying } from '../model/words.js';
import type { SceneLayer, Viewpoint } from '../view/scene_view.js';
import { button, card, el, setData, setShown, setText } from '../common/dom.js';

/** Which scene, and with what token. */
export class PickCard {
  readonly element: HTMLElement;
  private readonly select: HTMLSelectElement;
  private readonly token = el('input', { id: 'token', attributes: {
    'type': 'password', 'autocomplete': 'off', 'spellcheck': 'false' } });
  private readonly access: HTMLDetailsElement;
  private readonly title = el('p', { class: 'status-title', id: 'state' });
  private readonly text = el('p', { class: 'status-text', id: 'state-text' });

  constructor(onScene: (name: string) => void,
      onToken: (token: string) => void, token: string) {
    this.select = el('select', { id: 'scene', on: {
      change: () => onScene(this.select.value) } });
    this.token.value = token;
    this.token.addEventListener('keydown', (event) => {
      if (event.key === 'Enter') onToken(this.token.value.trim());
    });
    this.access = el('details', { id: 'access' }, el('summary', {}, 'Access'),
        el('label', { attributes: { for: 'token' } }, 'Token of the server'),
        el('div', { class: 'row' }, this.token, button('Use',
            () => onToken(this.token.value.trim()), { id: 'use-token' })),
        el('p', { class: 'detail' }, 'Needed where the server asks for one. ' +
          'It is kept until this window closes.'));
    this.element = card('Scene', 'scene-card',
        el('label', { class: 'hidden-label', attributes: { for: 'scene' } },
            'Scene'),
        el('div', { class: 'row' }, this.select),
        el('div', { attributes: { role: 'status' } }, this.title, this.text),
        this.access);
    this.setScenes([], '');
  }

  get scene(): string {
    return this.select.value;
  }

  setScenes(scenes: readonly Scene[], chosen: string): void {
    this.select.replaceChildren(...scenes.map(({ name, displayName }) => {
      const option = el('option', { attributes: { value: name } },
          displayName || name);
      option.selected = name === chosen;
      return option;
    }));
    if (scenes.length === 0) {
      this.select.append(
          el('option', { attributes: { value: '' } }, 'No scene'));
    }
  }

  say({ title, text, tone }: Saying): void {
    setText(this.title, title);
    setText(this.text, text);
    setData(this.element, 'tone', tone);
  }

  askForToken(): void {
    this.access.open = true;
    this.token.focus();
  }
}

const LAYERS: readonly (readonly [SceneLayer, string])[] = [
  ['points', 'Points of the model'],
  ['path', 'Where it was recorded'],
  ['coverage', 'Where it will work'],
  ['queries', 'Where queries were located'],
];

const VIEWPOINTS: readonly (readonly [Viewpoint, string])[] = [
  ['overview', 'All'], ['above', 'From above'], ['side', 'From the side'],
];

export interface LookEvents {
  readonly onLayer: (layer: SceneLayer, isShown: boolean) => void;
  readonly onLook: (from: Viewpoint) => void;
  readonly onZoom: (factor: number) => void;
}

export class LookCard {
  readonly element: HTMLElement;

  constructor(events: LookEvents) {
    const layers = LAYERS.map(([layer, label]) => {
      const check = el('input', { id: `show-${layer}`,
        attributes: { type: 'checkbox' },
        on: { change: () => events.onLayer(layer, check.checked) } });
      check.checked = true;
      return el('label', { class: 'check' }, check, label);
    });
    const views = VIEWPOINTS.map(([from, label]) =>
      button(label, () => events.onLook(from), { id: `look-${from}` }));
    this.element = card('View', 'look-card',
        el('div', { class: 'row wrap' }, ...views,
            button('+', () => events.onZoom(0.7), { id: 'nearer',
              attributes: { 'aria-label': 'Nearer' } }),
            button('−', () => events.onZoom(1 / 0.7), { id: 'farther',
              attributes: { 'aria-label': 'Farther' } })),
        ...layers);
  }
}

/** What the model knows, and how well it will answer. */
export class ModelCard {
  readonly element: HTMLElement;
  private readonly description = el('p', { id: 'description' });
  private readonly figures = el('dl', { class: 'figures' });
  private readonly legend: HTMLElement;

  constructor() {
    this.legend = el('div', { class: 'legend', id: 'legend' },
        el('div', { class: 'legend-bar', attributes: { 'aria-hidden': 'true' } }),
        el('div', { class: 'legend-ends' }, el('span', {}, 'from no heading'),
            el('span', {}, 'from all')),
        el('p', { class: 'detail' }, 'The floor shows from how many headings ' +
          'a camera there will be located. Nothing is said of what is blank.'));
    this.element = card('Model', 'model-card', this.description, this.figures,
        this.legend);
    this.setMap(null, null);
  }

  setMap(scene: Scene | null, map: SceneMap | null): void {
    setText(this.description, map === null ? 'Nothing is shown.' :
      describeMap(map));
    const coverage = map?.coverage ?? null;
    setShown(this.legend, coverage !== null);
    const rows: (readonly [string, string])[] = [];
    if (map !== null) {
      rows.push(['Version', map.modelVersion], ['Method', scene?.method ?? '–'],
          ['Points shown', map.brightness.length.toLocaleString('en')]);
    }
    if (coverage !== null) {
      rows.push(['Views that will be answered', percentOf(coverage.goodShare)],
          ['Perhaps', percentOf(coverage.weakShare)],
          ['Camera height above the floor',
            `${(coverage.heightM - coverage.groundM).toFixed(2)} m`]);
    }
    setShown(this.figures, rows.length > 0);
    this.figures.replaceChildren(...rows.map(([label, value]) =>
      el('div', {}, el('dt', {}, label), el('dd', {}, value))));
  }
}

const timeOf = (timeUtc: string): string =>
  new Date(timeUtc).toLocaleTimeString([], { hour12: false });

/** The latest queries, and why they failed. */
export class QueriesCard {
  readonly element: HTMLElement;
  private readonly note = el('p', { class: 'detail', id: 'queries-note',
    attributes: { role: 'status' } });
  private readonly list = el('ul', { class: 'queries', id: 'queries' });

  constructor(private readonly onChoose: (query: RecentQuery | null) => void) {
    this.element = card('Latest queries', 'queries-card', this.note, this.list);
  }

  /** Null: the server keeps none. */
  setQueries(queries: readonly RecentQuery[] | null,
      chosen: RecentQuery | null): void {
    if (queries === null) {
      setText(this.note, 'This server keeps no queries. Setting ' +
          'recent_queries = 100 keeps the results of so many, without ' +
          'pictures.');
      this.list.replaceChildren();
      return;
    }
    const { located, notLocated, failed } = countQueries(queries);
    setText(this.note, queries.length === 0 ? 'None yet.' :
      `${located} located, ${notLocated} not located, ${failed} failed.`);
    // Who reads or tabs through the list keeps his place.
    const focused = document.activeElement?.id ?? '';
    this.list.replaceChildren(...queries.map((query) =>
      el('li', {}, this.rowOf(query, isSame(query, chosen)))));
    if (focused.startsWith('query-')) {
      (document.getElementById(focused) ??
          this.list.querySelector('button'))?.focus();
    }
  }

  private rowOf(query: RecentQuery, isChosen: boolean): HTMLElement {
    const isLocated = query.worldFromCamera !== null;
    const row = button('', () => this.onChoose(isChosen ? null : query), {
      class: 'query', id: `query-${query.timeUtc}`,
      attributes: { 'aria-pressed': String(isChosen) } });
    setData(row, 'tone', isLocated ? 'calm' : query.isError ? 'bad' : 'warn');
    row.append(
        el('span', { class: 'query-head' },
            el('span', { class: 'query-what' }, isLocated ? 'Located' :
              query.isError ? 'Failed' : 'Not located'),
            el('span', { class: 'detail' }, `${timeOf(query.timeUtc)}, ` +
                `${query.totalMs.toFixed(0)} ms`)),
        // Never more than there is: 99.97 % is not 100 %.
        el('span', { class: 'detail' }, isLocated ?
          `${Math.floor(100 * query.confidence)} % sure, ${query.inliers} of ` +
              `${query.samples} points agree` : reasonInWords(query.reason)));
    return row;
  }
}

/** Results have no number: their time is one. */
export const isSame = (a: RecentQuery, b: RecentQuery | null): boolean =>
  a.timeUtc === b?.timeUtc && a.totalMs === b.totalMs;
