// The routes that are kept, and what a route needs that is being drawn.

import type { Route, Routes, Waypoint } from '../api/types.js';
import {
  freeRouteName, LONGEST_WAIT_S, MOST_NAME_BYTES, routeDetail, RouteDraft,
} from '../model/route_draft.js';
import { button, el, setShown, setText } from '../common/dom.js';

export interface RouteCommands {
  // Both reject if the agent refuses it.
  put(route: Route): Promise<void>;
  run(route: Route): Promise<void>;
  runKept(name: string): void;
  remove(name: string): void;
  // The draft has changed: to be drawn.
  drawn(waypoints: readonly Waypoint[], isLoop: boolean): void;
  // The tool is not needed any more.
  done(): void;
}

const HINT = 'Click the waypoints in their order; drag to choose a heading.';

export class RoutesPanel {
  readonly element: HTMLElement;
  // Over the map while one draws.
  readonly bar: HTMLElement;
  private readonly draft = new RouteDraft();
  private readonly list = el('ul', { class: 'obstacles routes' });
  private readonly none = el('p', { class: 'detail' },
      'None is kept. Draw one with the tool on the map.');
  private readonly warning = el('p', { class: 'detail', id: 'routes-warning' });
  private readonly hint = el('p', {
    class: 'zone-hint', id: 'route-hint', attributes: { 'aria-live': 'polite' } });
  private readonly wait = el('input', {
    id: 'route-wait',
    attributes: {
      'type': 'number', 'min': '0', 'max': String(LONGEST_WAIT_S), 'step': '1',
      'aria-label': 'Wait at the newest waypoint, seconds' },
    on: { input: () => this.draft.setWait(Number(this.wait.value)) },
  });
  private readonly loop = this.check('route-loop', 'Loop');
  private readonly stops = this.check('route-stops', 'Stop if one is missed');
  private readonly name = el('input', {
    id: 'route-name', class: 'route-name',
    attributes: {
      'type': 'text', 'maxlength': String(MOST_NAME_BYTES),
      'aria-label': 'Name of the route' },
  });
  private readonly undo = button('Undo', () => {
    this.draft.undo();
    this.show();
  }, { id: 'route-undo' });
  private readonly save = button('Save', () => this.send('put'),
      { id: 'route-save' });
  private readonly run = button('Run', () => this.send('run'),
      { id: 'route-run' });
  private routes: Routes = {
    revision: 0, routes: [], current: null, warning: '' };
  private isSending = false;

  constructor(private readonly commands: RouteCommands) {
    this.bar = el('div', { class: 'zone-bar route-bar needs-link', attributes: {
      'role': 'group', 'aria-label': 'Route that is being drawn' } },
    this.hint,
    el('div', { class: 'row' },
        el('label', { class: 'zone-speed' }, el('span', {}, 'Wait'), this.wait,
            el('span', {}, 's')),
        this.loop.row, this.stops.row),
    el('div', { class: 'row' }, this.name, this.undo, this.save, this.run));
    this.element = el('details', { class: 'card', id: 'routes' },
        el('summary', {}, 'Routes'),
        el('div', { class: 'needs-link' }, this.none, this.list,
            this.warning));
    this.enable(false);
    this.update(this.routes);
  }

  private check(id: string, label: string):
      { row: HTMLElement; box: HTMLInputElement } {
    const box = el('input', { id, attributes: { type: 'checkbox' },
      on: { change: () => this.show() } });
    return { row: el('label', { class: 'check' }, box, label), box };
  }

  enable(isOn: boolean): void {
    this.draft.clear();
    if (isOn) this.name.value = freeRouteName(this.routes.routes);
    setShown(this.bar, isOn);
    this.show();
  }

  addWaypoint(waypoint: Omit<Waypoint, 'wait' | 'name'>): void {
    this.draft.add(waypoint);
    this.show();
  }

  update(routes: Routes): void {
    this.routes = routes;
    setShown(this.none, routes.routes.length === 0);
    setText(this.warning, routes.warning);
    setShown(this.warning, routes.warning !== '' && routes.routes.length > 0);
    this.list.replaceChildren(...routes.routes.map((route) => this.row(route)));
  }

  private row(route: Route): HTMLElement {
    const { name } = route;
    return el('li', {},
        el('span', {}, name),
        el('span', { class: 'detail' }, routeDetail(route)),
        button('Run', () => this.commands.runKept(name), {
          class: 'small', attributes: { 'aria-label': `Run ${name}` } }),
        button('Remove', () => this.commands.remove(name), {
          class: 'small', attributes: { 'aria-label': `Remove ${name}` } }));
  }

  private show(): void {
    const { waypoints } = this.draft;
    const isEmpty = waypoints.length === 0;
    this.undo.disabled = isEmpty;
    this.wait.disabled = isEmpty;
    this.save.disabled = isEmpty || this.isSending;
    this.run.disabled = isEmpty || this.isSending;
    this.wait.value = String(this.draft.lastWait);
    setText(this.hint, isEmpty ? HINT : waypoints.length === 1 ?
      '1 waypoint. Go on, run it, or save it.' :
      `${waypoints.length} waypoints. Go on, run it, or save it.`);
    this.commands.drawn(waypoints, this.loop.box.checked);
  }

  // What the agent refuses stays, to be mended.
  private async send(how: 'put' | 'run'): Promise<void> {
    const route = this.draft.route(
        this.name.value, this.loop.box.checked, this.stops.box.checked);
    this.isSending = true;
    this.show();
    try {
      await this.commands[how](route);
      if (how === 'run') {
        this.draft.clear();
        this.commands.done();
      }
    } catch {
      // It was told already.
    } finally {
      this.isSending = false;
      this.show();
    }
  }
}
