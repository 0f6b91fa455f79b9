// The scene page: what a model knows, where it will work, and what became of
// the latest queries.

import './common/page.css';
import './style.css';
import './scene.css';

import { TreelineClient, TreelineError, type RecentQuery, type Scene } from
  '@treeline/client';

import { Settings } from './model/settings.js';
import { sayingOfError, type Saying } from './model/words.js';
import { el } from './common/dom.js';
import { isSame, LookCard, ModelCard, PickCard, QueriesCard } from
  './panels/scene_page_cards.js';
import { SceneView } from './view/scene_view.js';

const LOADING: Saying = { title: 'Loading', tone: 'busy',
  text: 'The first look at a scene computes where it will work.' };
const NONE: Saying = { title: 'No scene', tone: 'warn',
  text: 'The server has no scene.' };
const NO_POINTS: Saying = { title: 'No points', tone: 'warn',
  text: 'This model has no keyframes. Train it with method universal, from a ' +
    'recording that has depth.' };
const SHOWN: Saying = { title: 'Shown', tone: 'calm',
  text: 'Drag to turn, pinch or scroll to zoom.' };

// Computing where a scene will work takes a while, once.
const MAP_TIMEOUT_MS = 60_000;
const QUERIES_INTERVAL_MS = 2000;

class ScenePage {
  private readonly settings = new Settings(localStorage, sessionStorage);
  private readonly client = new TreelineClient({
    // The page lies in ar/ of the server.
    servers: new URL('..', window.location.href).href,
    token: () => this.settings.token,
  });
  private readonly view = new SceneView();
  private readonly pick = new PickCard(() => void this.showScene(),
      (token) => void this.useToken(token), this.settings.token);
  private readonly look = new LookCard({
    onLayer: (layer, isShown) => this.view.show(layer, isShown),
    onLook: (from) => this.view.look(from),
    onZoom: (factor) => this.view.zoom(factor),
  });
  private readonly model = new ModelCard();
  private readonly queriesCard = new QueriesCard((query) => {
    this.chosen = query;
    this.showQueries();
  });
  private scenes: readonly Scene[] = [];
  private queries: readonly RecentQuery[] | null = [];
  private chosen: RecentQuery | null = null;
  // Of the scene that is shown; what belongs to another comes too late.
  private showing = new AbortController();

  constructor() {
    document.body.append(
        el('header', { class: 'head' }, el('span', { class: 'mark' }),
            el('h1', {}, 'Treeline scene'),
            el('nav', {}, el('a', { class: 'head-link',
              attributes: { href: './' } }, 'Camera'))),
        el('main', {}, el('section', { class: 'stage', attributes: {
          'aria-label': 'Picture of the scene' } }, this.view.element),
        el('div', { class: 'side' }, this.pick.element, this.model.element,
            this.queriesCard.element, this.look.element)));
    // Tests ask where things are drawn.
    Object.assign(window, { treeline: { shareOf: (
        x: number, y: number, z: number) => this.view.shareOf(x, y, z) } });
    window.setInterval(() => {
      if (document.visibilityState === 'visible') void this.loadQueries();
    }, QUERIES_INTERVAL_MS);
  }

  async loadScenes(): Promise<void> {
    try {
      this.scenes = await this.client.scenes();
    } catch (error) {
      this.fail(error);
      return;
    }
    const asked = new URLSearchParams(window.location.search).get('scene');
    const chosen = this.scenes.find(({ name }) => name === asked) ??
        this.scenes.find(({ state }) => state === 'ready') ?? this.scenes[0];
    this.pick.setScenes(this.scenes, chosen?.name ?? '');
    await this.showScene();
  }

  private async useToken(token: string): Promise<void> {
    this.settings.keepToken(token);
    await this.loadScenes();
  }

  private async showScene(): Promise<void> {
    this.showing.abort();
    const { signal } = this.showing = new AbortController();
    const { scene } = this.pick;
    this.view.setMap(null);
    this.model.setMap(null, null);
    this.queries = [];
    this.chosen = null;
    if (scene === '') {
      this.pick.say(NONE);
      return;
    }
    this.pick.say(LOADING);
    void this.loadQueries();
    try {
      const map = await this.client.sceneMap(scene, { wantsCoverage: true },
          { signal, timeoutMs: MAP_TIMEOUT_MS });
      if (signal.aborted) return;
      // One that was loaded for this says now what it is.
      const info = await this.client.scene(scene, { signal });
      this.view.setMap(map);
      this.model.setMap(info, map);
      this.showQueries();
      this.pick.say(SHOWN);
    } catch (error) {
      if (!signal.aborted) this.fail(error);
    }
  }

  private fail(error: unknown): void {
    if (error instanceof TreelineError) {
      if (error.reason === 'NO_KEYFRAMES') {
        this.pick.say(NO_POINTS);
        return;
      }
      if (error.code === 'unauthenticated') this.pick.askForToken();
    }
    this.pick.say(sayingOfError(error));
  }

  private async loadQueries(): Promise<void> {
    const { scene } = this.pick;
    const { signal } = this.showing;
    // Who keeps none does not begin to.
    if (scene === '' || this.queries === null) return;
    let queries: readonly RecentQuery[] | null;
    try {
      queries = await this.client.recentQueries(scene, { signal });
    } catch (error) {
      const isOff = error instanceof TreelineError &&
          error.reason === 'RECENT_QUERIES_OFF';
      // Otherwise the next one may be answered.
      if (!isOff) return;
      queries = null;
    }
    if (signal.aborted) return;
    const isNew = queries === null || this.queries === null ||
        queries.length !== this.queries.length ||
        queries.some((query, i) => !isSame(query, this.queries![i]!));
    this.queries = queries;
    if (isNew || queries?.length === 0) this.showQueries();
  }

  private showQueries(): void {
    const shown = this.queries ?? [];
    this.queriesCard.setQueries(this.queries, this.chosen);
    this.view.setQueries(shown,
        shown.findIndex((query) => isSame(query, this.chosen)));
  }
}

function begin(): void {
  let page: ScenePage;
  try {
    page = new ScenePage();
  } catch (error) {
    document.body.append(el('p', { class: 'empty' },
        'This page needs WebGL, which this browser does not give: ' +
        `${String(error)}`));
    return;
  }
  void page.loadScenes();
}

begin();
