// Wires the page: what the agent says goes to map and panels, what a person
// does goes to the agent.

import { createConnectTransport } from '@connectrpc/connect-web';

import { AgentClient } from './api/client.js';
import { AgentStream, type Link } from './api/stream.js';
import type { AgentInfo, Dock, RobotState, Route } from './api/types.js';
import { loadFields, loadLevelPicture, loadVoxels } from './map_loader.js';
import { shownLevel } from './model/levels.js';
import { isRouteOpen } from './model/route_draft.js';
import { meshOf } from './model/voxel_mesh.js';
import { CameraPanel } from './panels/camera_panel.js';
import { DrivePanel } from './panels/drive_panel.js';
import { el } from './common/dom.js';
import { HeadLine, LostBanner, Toasts } from './panels/frame.js';
import { DevicesPanel, EventsPanel } from './panels/list_panels.js';
import { MapBar, type Tool } from './panels/map_bar.js';
import { Scale } from './panels/map_help.js';
import { DocksPanel } from './panels/docks_panel.js';
import { SimulationPanel } from './panels/simulation_panel.js';
import { RoutesPanel } from './panels/routes_panel.js';
import { StopBar } from './panels/stop_bar.js';
import { LostPanel, StatusPanel } from './panels/status_panel.js';
import { ZonesPanel } from './panels/zones_panel.js';
import './common/page.css';
import './style.css';
import { MapView } from './view/map_view.js';
import { Placing, type Placed } from './view/placing.js';

const OBSTACLE_SIZE_M = 0.5;
// A map that could not be fetched is fetched again after this.
const MAP_RETRY_MS = 3000;

class Page {
  private readonly client = new AgentClient(
      createConnectTransport({
        // Beside the page, wherever that is.
        baseUrl: new URL('.', document.baseURI).href,
        useBinaryFormat: true,
      }),
      (url, init) => fetch(url, init));
  private readonly stream: AgentStream;
  private readonly toasts = new Toasts();
  private readonly stop: StopBar;
  private readonly head: HeadLine;
  private readonly banner = new LostBanner(() => this.stream.retryNow());
  private readonly host = el('div', { class: 'map', id: 'map' });
  private readonly view: MapView | null;
  private readonly placing: Placing | null;
  private readonly bar: MapBar;
  private readonly scale = new Scale();
  private readonly status: StatusPanel;
  private readonly lost = new LostPanel();
  private readonly camera = new CameraPanel(this.client);
  private readonly drive: DrivePanel;
  private readonly devices = new DevicesPanel();
  private readonly events = new EventsPanel();
  private readonly simulation: SimulationPanel;
  private readonly zones: ZonesPanel;
  private readonly routes: RoutesPanel;
  private readonly docks: DocksPanel;
  private docksRevision = -1;
  private fetchesDocks = false;
  private routesRevision = -1;
  private fetchesRoutes = false;
  // The route under way as it was fetched, and the one that is shown.
  private current: Route | null = null;
  private shownRoute: Route | null = null;
  // Of the zones that are shown, and whether they are fetched.
  private zonesRevision = -1;
  private fetchesZones = false;
  private info: AgentInfo | null = null;
  // The map that is shown, as text.
  private shownMap = '';
  private isLoading = false;
  private state: RobotState | null = null;
  private lastHeard = 0;
  private pickedLevel: number | null = null;
  private level = 0;
  private tool: Tool = 'look';
  private garbled = 0;

  constructor() {
    const { client } = this;
    this.stop = new StopBar({
      stop: () => {
        this.drive.letGo();
        this.askOrWarn(client.stop(), 'Stopped.');
      },
      release: () => this.askOrWarn(client.release(), 'Released.'),
    });
    this.head = new HeadLine(this.stop.button);
    // Of this page alone, whichever other pages there are.
    const driver = `page-${[...crypto.getRandomValues(new Uint32Array(2))]
        .map((part) => part.toString(36)).join('')}`;
    this.drive = new DrivePanel(
        ({ forward, yawRate }, sequence) =>
          client.drive(forward, yawRate, driver, sequence),
        (error) => this.tell(error));
    this.view = this.makeView();
    this.placing = this.view && new Placing(this.view,
        () => this.tool === 'goal' ? this.state?.pose ?? null : null,
        (placed) => this.place(placed));
    this.zones = new ZonesPanel({
      put: (zone) => client.putZone(zone).then(
          (warning) => this.toasts.say(
              `${zone.name} is there now. ${warning}`.trim(),
              warning === '' ? 'calm' : 'bad'),
          (error: unknown) => {
            this.tell(error);
            throw error;
          }),
      remove: (name) => this.ask(client.removeZone(name), `${name} is gone.`),
      drawn: (corners, level, kind) =>
        this.view?.setZoneDraft(corners, level, kind),
      done: () => this.bar.choose('look'),
    });
    this.routes = this.makeRoutes();
    this.docks = new DocksPanel({
      putHere: (name, isBackward) => this.putDock(
          { name, isBackward, x: 0, y: 0, yaw: 0, level: 0 }, true),
      go: (name) => this.ask(client.dock(name), `Drives to ${name}.`),
      out: () => this.ask(client.undock(), 'Drives out.'),
      remove: (name) => this.ask(client.removeDock(name), `${name} is gone.`),
    });
    this.bar = new MapBar({
      level: (picked) => {
        this.pickedLevel = picked;
        this.followLevel();
      },
      layer: (name, isShown) => this.view?.show(name, isShown),
      cut: (aboveGround) => this.view?.setCut(aboveGround),
      look: (angle) => this.view?.look(angle),
      follow: (isOn) => this.view?.follow(isOn),
      tool: (tool) => {
        this.tool = tool;
        this.placing?.enable(tool !== 'look');
        this.zones.enable(tool === 'zone');
        this.routes.enable(tool === 'route');
      },
    });
    this.status = new StatusPanel({
      pause: () => this.ask(client.pause(), 'Paused.'),
      resume: () => this.ask(client.resume(), 'Going on.'),
      cancel: () => this.ask(client.cancel(), 'Goal cancelled.'),
      findYourself: () =>
        this.ask(client.findYourself(), 'The robot looks for its place.'),
      resumeRoute: () => this.ask(client.resumeRoute(), 'Going on.'),
      cancelRoute: () => this.ask(client.cancelRoute(), 'Route ended.'),
    });
    this.simulation = new SimulationPanel({
      kidnapAnywhere: () => this.ask(client.kidnapTo(null), 'Kidnapped.'),
      kidnapTo: (place) => this.ask(client.kidnapTo({ place }), 'Kidnapped.'),
      removeObstacle: (name) =>
        this.ask(client.removeObstacle(name), 'Box removed.'),
      fault: (target, kind, seconds) => this.ask(
          client.injectFault(target, kind, seconds),
          `${target} ${kind} for ${seconds} s.`),
    }, this.bar.simulationTools);
    this.simulation.element.hidden = true;
    this.stream = new AgentStream({
      watch: (signal) => client.watch(signal),
      later: (work, ms) => window.setTimeout(work, ms),
      forget: (timer) => window.clearTimeout(timer),
    }, {
      state: (state) => this.setState(state),
      scene: (scene) => {
        this.view?.setScene(scene);
        this.simulation.update(scene);
      },
      event: (event) => this.events.add(event),
      link: (link) => this.setLink(link),
      garbled: (error) => this.tellGarbled(error),
    });
    this.build();
  }

  private makeRoutes(): RoutesPanel {
    const { client } = this;
    const tellAndThrow = (error: unknown): never => {
      this.tell(error);
      throw error;
    };
    return new RoutesPanel({
      put: (route) => client.putRoute(route).then(
          (warning) => this.toasts.say(
              `${route.name} is kept. ${warning}`.trim(),
              warning === '' ? 'calm' : 'bad'), tellAndThrow),
      run: (route) => client.runRoute(route).then(
          () => this.toasts.say('Route sent.', 'calm'), tellAndThrow),
      runKept: (name) => this.ask(client.runRoute(name), `${name} begins.`),
      remove: (name) => this.ask(client.removeRoute(name), `${name} is gone.`),
      drawn: (waypoints, isLoop) =>
        this.view?.setRouteDraft(waypoints, isLoop),
      done: () => this.bar.choose('look'),
    });
  }

  private makeView(): MapView | null {
    try {
      return new MapView(this.host);
    } catch {
      this.host.append(el('p', { class: 'no-map' },
          'This browser cannot draw the map: WebGL is missing or switched ' +
          'off. Everything else works.'));
      return null;
    }
  }

  private build(): void {
    this.host.append(
        el('span', { class: 'crosshair', attributes: { 'aria-hidden': 'true' } }),
        this.bar.top, this.scale.element,
        el('div', { class: 'map-bottom' }, this.bar.hint, this.zones.bar,
            this.routes.bar, this.bar.tools));
    const side = el('div', { class: 'side' },
        this.status.element, this.drive.element, this.lost.element,
        this.routes.element, this.docks.element, this.zones.element,
        this.simulation.element);
    const watch = el('div', { class: 'watch' },
        this.camera.element, this.devices.element, this.events.element);
    document.body.append(this.head.element, this.stop.banner,
        this.banner.element,
        el('main', {}, this.host, el('div', { class: 'rest' }, side, watch)),
        this.toasts.element);
    this.setLink('connecting');
    this.bar.applyLayers();
    if (this.view !== null) {
      this.view.onScale = (pixels) => this.scale.set(pixels);
    }
    document.addEventListener('keydown', (event) => this.press(event));
  }

  // Keys that are not meant for the control that has the focus.
  private press(event: KeyboardEvent): void {
    if (event.ctrlKey || event.metaKey || event.altKey || event.repeat) return;
    const at = event.target;
    const isFree = at === document.body || at === this.view?.canvas;
    if (event.key === ' ' && isFree) this.status.pressPause();
    else if (event.key.toLowerCase() === 'x') this.stop.button.click();
    else if (at instanceof HTMLSelectElement) return;
    else if (!this.bar.press(event.key.toLowerCase())) return;
    event.preventDefault();
  }

  start(): void {
    this.stream.start();
    window.addEventListener('online', () => this.stream.retryNow());
    document.addEventListener('visibilitychange', () => {
      if (!document.hidden) this.stream.retryNow();
    });
  }

  windowOf(x: number, y: number, z: number): { x: number; y: number } | null {
    return this.view?.windowOf(x, y, z) ?? null;
  }

  drawn(): { triangles: number; levels: number } | null {
    return this.view?.drawn() ?? null;
  }

  // ---- from the agent ----

  private setLink(link: Link): void {
    this.head.setLink(link);
    this.banner.setLink(link, this.lastHeard);
    this.camera.setLive(link === 'live');
    if (link !== 'live') this.drive.letGo();
    for (const part of document.querySelectorAll<HTMLElement>('.needs-link')) {
      part.inert = link !== 'live';
    }
    // An agent that began anew counts anew.
    this.zonesRevision = -1;
    this.routesRevision = -1;
    this.docksRevision = -1;
    if (link === 'live') void this.loadMap();
  }

  private async loadZones(): Promise<void> {
    if (this.fetchesZones) return;
    this.fetchesZones = true;
    try {
      const zones = await this.client.zones();
      this.zonesRevision = zones.revision;
      this.zones.update(zones, this.info?.levels.length ?? 1);
      this.view?.setZones(zones);
      this.fetchesZones = false;
    } catch (error) {
      this.tell(error);
      window.setTimeout(() => { this.fetchesZones = false; }, MAP_RETRY_MS);
    }
  }

  private async loadDocks(): Promise<void> {
    if (this.fetchesDocks) return;
    this.fetchesDocks = true;
    try {
      const docks = await this.client.docks();
      this.docksRevision = docks.revision;
      this.docks.update(docks, this.info?.levels.length ?? 1);
      this.view?.setDocks(docks.docks);
      this.fetchesDocks = false;
    } catch (error) {
      this.tell(error);
      window.setTimeout(() => { this.fetchesDocks = false; }, MAP_RETRY_MS);
    }
  }

  private async loadRoutes(): Promise<void> {
    if (this.fetchesRoutes) return;
    this.fetchesRoutes = true;
    try {
      const routes = await this.client.routes();
      this.routesRevision = routes.revision;
      this.routes.update(routes);
      this.current = routes.current;
      this.showRoute();
      this.fetchesRoutes = false;
    } catch (error) {
      this.tell(error);
      window.setTimeout(() => { this.fetchesRoutes = false; }, MAP_RETRY_MS);
    }
  }

  // Its marks go with its end.
  private showRoute(): void {
    const route = isRouteOpen(this.state?.route ?? null) ? this.current : null;
    if (route === this.shownRoute) return;
    this.shownRoute = route;
    this.view?.setRoute(route);
  }

  private async loadMap(): Promise<void> {
    if (this.isLoading) return;
    this.isLoading = true;
    try {
      const info = await this.client.info();
      const text = JSON.stringify([info.mapName, info.levels, info.world]);
      this.info = info;
      this.head.setInfo(info);
      this.bar.setLevels(info.levels.length, info.simulated);
      this.camera.setServer(info.server);
      this.simulation.element.hidden = !info.simulated;
      this.simulation.setPlaces(info.places);
      if (text !== this.shownMap) {
        await this.showMap(info);
        this.shownMap = text;
      }
    } catch (error) {
      this.tell(error);
      // A slow network or a busy robot: the map is there all the same.
      window.setTimeout(() => {
        if (this.stream.link === 'live') void this.loadMap();
      }, MAP_RETRY_MS);
    } finally {
      this.isLoading = false;
    }
  }

  private async showMap(info: AgentInfo): Promise<void> {
    const { view, client } = this;
    if (view === null) return;
    const voxels = await loadVoxels(client);
    const fields = await loadFields(client, info, voxels);
    view.setMap(info, fields);
    this.followLevel();
    const mesh = meshOf(voxels);
    view.setVoxels(mesh);
    this.bar.help.setHeights(
        mesh.bottom, mesh.bottom + mesh.bodyEnds.length * mesh.resolution);
    await Promise.all(fields.map(async (field) => view.addLevelPicture(
        field, await loadLevelPicture(client, field.level.index))));
    this.host.dataset.map = 'ready';
  }

  private setState(state: RobotState): void {
    this.lastHeard = Date.now();
    this.state = state;
    this.followLevel();
    if (state.zonesRevision !== this.zonesRevision) void this.loadZones();
    if (state.routesRevision !== this.routesRevision) void this.loadRoutes();
    if (state.docking !== null && state.docksRevision !== this.docksRevision) {
      void this.loadDocks();
    }
    this.docks.follow(state.docking);
    this.showRoute();
    this.view?.setState(state);
    this.stop.update(state);
    this.status.update(state);
    this.lost.update(state);
    this.camera.update(state);
    this.devices.update(state);
  }

  private followLevel(): void {
    const robot = this.state?.pose?.level ?? null;
    this.bar.showLevel(robot ?? 0);
    const level =
        shownLevel(this.pickedLevel, robot, this.info?.levels.length ?? 1);
    if (level === this.level && this.view?.field(level) === null) return;
    this.level = level;
    this.view?.showLevel(level);
  }

  private tellGarbled(error: Error): void {
    // Once: they come many times a second.
    if (++this.garbled === 1) this.toasts.say(error.message, 'bad');
  }

  // ---- to the agent ----

  private place({ x, y, yaw, isAimed }: Placed): void {
    const { client, level } = this;
    const pose = { x, y, yaw, level };
    const tool = this.tool;
    if (tool === 'zone') {
      this.zones.addCorner({ x, y }, level);
      return;
    }
    if (tool === 'route') {
      this.routes.addWaypoint({ x, y, level, yaw: isAimed ? yaw : null });
      return;
    }
    this.bar.choose('look');
    if (tool === 'goal') this.ask(client.sendGoal([pose]), 'Goal sent.');
    if (tool === 'dock') {
      const { name, isBackward } = this.docks;
      this.putDock({ ...pose, name, isBackward }, false);
    }
    if (tool === 'pose') this.ask(client.setPose(pose), 'Pose sent.');
    if (tool === 'kidnap') this.ask(client.kidnapTo(pose), 'Kidnapped.');
    if (tool === 'obstacle') {
      this.ask(client.addObstacle(x, y, level, OBSTACLE_SIZE_M),
          'A box stands there now.');
    }
  }

  private putDock(dock: Dock, isHere: boolean): void {
    this.askOrWarn(
        this.client.putDock(dock, isHere), `${dock.name} is there now.`);
  }

  private ask(answer: Promise<void>, done: string): void {
    answer.then(() => this.toasts.say(done, 'calm'),
        (error: unknown) => this.tell(error));
  }

  // As ask; the answer may be a warning.
  private askOrWarn(answer: Promise<string>, done: string): void {
    answer.then((warning) => this.toasts.say(
        warning === '' ? done : `${done} ${warning}`,
        warning === '' ? 'calm' : 'bad'),
    (error: unknown) => this.tell(error));
  }

  private tell(error: unknown): void {
    this.toasts.say(
        error instanceof Error ? error.message : String(error), 'bad');
  }
}

const page = new Page();
page.start();
// For the browser's console, and for tests: where a point of the map is drawn,
// and how much is.
Object.assign(window, { treeline: {
  drawn: () => page.drawn(),
  windowOf: (x: number, y: number, z: number) => page.windowOf(x, y, z),
} });
