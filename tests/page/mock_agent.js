// An agent that a test plays: it speaks treeline-agent's Connect and HTTP over a
// canned world, moves its robot along straight lines, and remembers what it was
// asked. As a program, `node mock_agent.js PAGE PORT`, for work on the page.
// TREELINE_PAGE_WORK: where `scripts/build-page --check` has worked.

import fs from 'node:fs';
import http from 'node:http';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

import * as world from './canned_world.js';
import { connect, dockMessages, messages, node, routeMessages } from './packages.js';

// What treeline-agent sends with every answer.
export const HEADERS = {
  'Content-Security-Policy': "default-src 'self'; img-src 'self' data: blob:; " +
    "style-src 'self'; object-src 'none'; base-uri 'none'; " +
    "frame-ancestors 'none'",
  'X-Content-Type-Options': 'nosniff',
  'Referrer-Policy': 'no-referrer',
};

const TYPES = {
  '.html': 'text/html; charset=utf-8', '.js': 'text/javascript; charset=utf-8',
  '.css': 'text/css; charset=utf-8', '.svg': 'image/svg+xml',
};

const SPEED_MPS = 0.8;

// What is still to be said on one stream.
class Queue {
  constructor(signal) {
    this.signal = signal;
    this.waiting = [];
    this.wake = () => {};
    signal.addEventListener('abort', () => this.wake());
  }

  push(message) {
    this.waiting.push(message);
    this.wake();
  }

  async* [Symbol.asyncIterator]() {
    while (!this.signal.aborted) {
      if (this.waiting.length > 0) yield this.waiting.shift();
      else await new Promise((resolve) => { this.wake = resolve; });
    }
  }
}

export class MockAgent {
  constructor({ pageFolder, picture = null, simulated = true }) {
    this.pageFolder = path.resolve(pageFolder);
    this.picture = picture;
    this.simulated = simulated;
    // What was asked: {method, body}.
    this.asked = [];
    // Method -> the message with which it is refused.
    this.refusals = new Map();
    this.pose = { x: 2.0, y: 4.9, yaw: 0 };
    this.mode = 'idle';
    this.cause = 'unspecified';
    this.causeText = '';
    this.advice = '';
    this.lost = { probability: 0.04, state: 'localized', reason: 'none' };
    this.goal = null;
    this.goalPoses = [];
    this.path = [];
    this.driven = 0;
    this.obstacles = [];
    this.fix = null;
    this.stopped = undefined;
    this.stopWarning = '';
    this.battery = undefined;
    this.zones = [];
    this.masks = [];
    this.zonesRevision = 1n;
    this.routes = [];
    // A RouteStatus, and the route it is of.
    this.route = undefined;
    this.current = undefined;
    this.routesRevision = 1n;
    this.docks = [];
    this.docking = {};
    this.docksRevision = 1n;
    this.events = [];
    this.time = 12;
    this.devices = ['laser', 'odometry', 'base', 'camera', 'server'].map(
        (name) => ({ name, state: 'running', cause: '' }));
    this.streams = new Set();
    this.isSilent = false;
    this.octomap = world.octomap();
    this.level = world.levelPicture();
    this.heights = world.heights();
  }

  async listen(port = 0) {
    const rpc = node.connectNodeAdapter({
      requireConnectProtocolHeader: true,
      routes: ({ service }) => this.addRoutes(service),
      fallback: (request, response) => this.answer(request, response),
    });
    this.server = http.createServer((request, response) => {
      for (const [name, value] of Object.entries(HEADERS)) {
        response.setHeader(name, value);
      }
      rpc(request, response);
    });
    await new Promise((resolve, reject) => {
      this.server.once('error', reject);
      this.server.listen(port, '127.0.0.1', resolve);
    });
    this.port = this.server.address().port;
    this.timer = setInterval(() => this.tick(0.1), 100);
    return `http://127.0.0.1:${this.port}/`;
  }

  // All at once, as a program that is killed.
  async vanish() {
    clearInterval(this.timer);
    this.streams.clear();
    const closed = new Promise((resolve) => this.server.close(resolve));
    this.server.closeAllConnections();
    await closed;
  }

  // Connections stay, and nothing comes any more.
  fallSilent() {
    clearInterval(this.timer);
    this.isSilent = true;
  }

  // The last message that was sent to `method`.
  lastAsked(method) {
    return this.asked.filter((entry) => entry.method === method).at(-1)?.body;
  }

  // ---- the robot ----

  say(kind, text) {
    const event = { number: BigInt(this.events.length + 1), timeS: this.time,
      kind, text };
    this.events.push(event);
    this.send({ state: this.state(), events: [event] });
  }

  tick(seconds) {
    this.time += seconds;
    if (this.mode === 'driving') this.drive(seconds);
    const hasScene = Math.round(this.time * 10) % 3 === 0;
    this.send({ state: this.state(), ...hasScene && { scene: this.scene() } });
  }

  drive(seconds) {
    const target = this.path[0];
    if (target === undefined) return;
    const [dx, dy] = [target.x - this.pose.x, target.y - this.pose.y];
    const distance = Math.hypot(dx, dy);
    const step = Math.min(distance, SPEED_MPS * seconds);
    this.driven += step;
    if (distance > 1e-6) {
      this.pose = { x: this.pose.x + dx / distance * step,
        y: this.pose.y + dy / distance * step, yaw: Math.atan2(dy, dx) };
    }
    if (step >= distance) this.path.shift();
    if (this.path.length === 0) {
      this.pose.yaw = this.goalPoses.at(-1).yawRad;
      this.goal.state = messages.GoalState.SUCCEEDED;
      this.mode = 'idle';
      this.say('goal', 'Arrived.');
    }
  }

  wayTo(goal) {
    const from = this.pose;
    const isAbove = world.groundAt(goal.x, goal.y) > 0.2;
    const isBelow = world.groundAt(from.x, from.y) < 0.2;
    const way = isAbove && isBelow ?
        [{ x: 3.6, y: 6.2 }, { x: 4.1, y: 8.5 }, { x: 9.4, y: 8.3 }] : [];
    return [...way, goal];
  }

  toGo() {
    let at = this.pose;
    let sum = 0;
    for (const next of this.path) {
      sum += Math.hypot(next.x - at.x, next.y - at.y);
      at = next;
    }
    return sum;
  }

  // The way ahead, every 0.1 m.
  densePath() {
    const out = [];
    let at = this.pose;
    for (const next of this.path) {
      const [dx, dy] = [next.x - at.x, next.y - at.y];
      const count = Math.max(1, Math.round(Math.hypot(dx, dy) / 0.1));
      for (let i = 0; i < count; ++i) {
        const [x, y] = [at.x + dx * i / count, at.y + dy * i / count];
        out.push([x, y, world.groundAt(x, y), Math.atan2(dy, dx)]);
      }
      at = next;
    }
    return out;
  }

  state() {
    const { x, y, yaw } = this.pose;
    const heightM = world.groundAt(x, y);
    return {
      timeS: this.time,
      mode: messages.NavigatorMode[this.mode.toUpperCase()],
      cause: messages.NavigationCause[this.cause.toUpperCase()] ?? 0,
      causeText: this.causeText, advice: this.advice,
      mapFromBase: { xM: x, yM: y, yawRad: yaw, heightM },
      // 6 cm, 0.03 rad.
      covariance: [0.0036, 0, 0, 0, 0.0036, 0, 0, 0, 0.0009],
      lostProbability: this.lost.probability, lostState: this.lost.state,
      lostReason: this.lost.reason,
      forwardMps: this.mode === 'driving' ? 0.58 : 0,
      ...this.goal && { goal: { ...this.goal, toGoM: this.toGo(),
        drivenM: this.driven, replans: 1 }, goalPoses: this.goalPoses },
      ...this.stopped && { stop: this.stopped },
      ...this.fix && { fix: this.fix }, devices: this.devices,
      ...this.simulated && { trueMapFromBase: {
        xM: x + 0.05, yM: y - 0.04, yawRad: yaw + 0.03, heightM } },
      steps: BigInt(Math.round(this.time * 40)),
      zonesRevision: this.zonesRevision,
      routesRevision: this.routesRevision,
      docking: { ...this.docking, docksRevision: this.docksRevision },
      ...this.route && { route: this.route },
      ...this.battery && { battery: this.battery },
    };
  }

  scene() {
    const { x, y } = this.pose;
    const route = this.densePath();
    const particles = [];
    for (let i = 0; i < 120; ++i) {
      const [a, r] = [i * 2.39996, 0.16 * Math.sqrt(i / 120)];
      particles.push(x + r * Math.cos(a), y + r * Math.sin(a),
          this.pose.yaw + 0.12 * Math.sin(3 * i));
    }
    return {
      path: route.map(([xM, yM, heightM, yawRad]) =>
        ({ xM, yM, heightM, yawRad })),
      bubbles: route.slice(2, 26).filter((_, i) => i % 3 === 0)
          .map(([xM, yM, heightM]) => ({ xM, yM, heightM, radiusM: 0.42 })),
      treeEdgesM: route.length === 0 ? [] : this.tree(),
      scanM: world.scanFrom(x, y), particles,
      blockages: this.obstacles.map(
          (box) => ({ xM: box.x, yM: box.y, radiusM: 0.45 })),
      costmap: world.costmapAround(
          x, y, world.groundAt(x, y), this.obstacles),
      obstacles: this.obstacles.map(
          (box) => ({ name: box.name, xM: box.x, yM: box.y })),
    };
  }

  // Not a search: twigs beside the way, always the same.
  tree() {
    const edges = [];
    let [x, y] = [2, 4.9];
    for (let i = 0; i < 160; ++i) {
      const [a, length] = [i * 2.4, 0.25 + 0.5 * ((i * 7) % 10) / 10];
      const next = [x + length * Math.cos(a), y + length * Math.sin(a)];
      edges.push(x, y, ...next);
      const share = (i % 40) / 40;
      [x, y] = [2.2 + 5.6 * share + 0.6 * Math.sin(i), 4.9 + 3 * share +
        0.5 * Math.cos(i)];
    }
    return edges;
  }

  // ---- Connect ----

  send(message) {
    for (const stream of this.streams) stream.push(message);
  }

  addRoutes(service) {
    const { NavigationService, SimulationService } = messages;
    // A method that answers with `give`, if it is not refused.
    const method = (name, give) => (body) => {
      this.asked.push({ method: name, body });
      const refusal = this.refusals.get(name);
      if (refusal !== undefined) {
        throw new connect.ConnectError(
            refusal, connect.Code.InvalidArgument);
      }
      return give(body) ?? {};
    };
    const obey = (name) => method(name, (body) => this.obey(name, body));
    const runRoute = method('RunRoute', (body) => {
      this.obey('RunRoute', body);
      return { route: this.route };
    });
    const navigate = method('Navigate', (body) => {
      this.obey('Navigate', body);
      return { goal: { ...this.goal } };
    });
    const dock = method('Dock', (body) => {
      this.obey('Dock', body);
      return { docking: this.docking };
    });
    service(dockMessages.DockingService, {
      getDocks: () => ({ revision: this.docksRevision, docks: this.docks,
        survivesRestart: true }),
      putDocks: obey('PutDocks'), removeDocks: obey('RemoveDocks'),
      async* dock(request, { signal }) {
        yield dock(request);
        await new Promise((end) => { signal.addEventListener('abort', end); });
      },
      undock: obey('Undock'),
    });
    service(NavigationService, {
      async* navigate(request, { signal }) {
        yield navigate(request);
        // The page listens no longer than that.
        await new Promise((end) => { signal.addEventListener('abort', end); });
      },
      async* runRoute(request, { signal }) {
        yield runRoute(request);
        await new Promise((end) => { signal.addEventListener('abort', end); });
      },
      getRoutes: () => ({ revision: this.routesRevision, routes: this.routes,
        current: this.current, survivesRestart: true }),
      putRoutes: obey('PutRoutes'), removeRoutes: obey('RemoveRoutes'),
      resumeRoute: obey('ResumeRoute'), cancelRoute: obey('CancelRoute'),
      getInfo: () => this.info(),
      streamState: (_request, { signal }) => this.stream(signal),
      cancel: obey('Cancel'), pause: obey('Pause'), resume: obey('Resume'),
      stop: obey('Stop'), release: obey('Release'), drive: obey('Drive'),
      getZones: () => ({ revision: this.zonesRevision, zones: this.zones,
        masks: this.masks, survivesRestart: true }),
      putZones: obey('PutZones'), removeZones: obey('RemoveZones'),
      setInitialPose: obey('SetInitialPose'),
      findYourself: obey('FindYourself'),
    });
    if (!this.simulated) return;
    service(SimulationService, {
      kidnap: obey('Kidnap'), addObstacle: obey('AddObstacle'),
      removeObstacle: obey('RemoveObstacle'), injectFault: obey('InjectFault'),
    });
  }

  info() {
    return {
      version: '0.1.0', robot: { frontM: 0.3, rearM: 0.3, halfWidthM: 0.31 },
      mapName: 'cafe', levels: [{ width: world.WIDTH, height: world.DEPTH,
        resolutionM: world.RESOLUTION_M, maxHeightM: 0.5 }],
      simulated: this.simulated, world: this.simulated ? 'cafe' : '',
      places: this.simulated ? ['terrace', 'entrance', 'kitchen'] : [],
      server: '127.0.0.1:50051',
    };
  }

  async* stream(signal) {
    const queue = new Queue(signal);
    if (!this.isSilent) this.streams.add(queue);
    try {
      if (!this.isSilent) yield { state: this.state(), scene: this.scene(),
        events: [...this.events] };
      yield* queue;
    } finally {
      this.streams.delete(queue);
    }
  }

  // ---- HTTP ----

  answer(request, response) {
    const url = new URL(request.url, 'http://agent').pathname;
    if (request.method !== 'GET') {
      this.refuse(response, 405, 'unimplemented', 'GET alone');
    } else if (url.startsWith('/api/')) this.give(url, response);
    else this.file(url, response);
  }

  reply(response, status, body, type = 'application/json') {
    response.writeHead(status, { 'Content-Type': type });
    response.end(Buffer.isBuffer(body) ? body : JSON.stringify(body));
  }

  refuse(response, status, code, message) {
    this.reply(response, status, { error: { code, message } });
  }

  give(url, response) {
    const picture = { 'api/camera.jpg': this.picture,
      'api/query.jpg': this.fix && this.picture }[url.slice(1)];
    if (url === '/api/octomap') {
      this.reply(response, 200, this.octomap, 'application/octet-stream');
    } else if (url === '/api/levels/0.png') {
      this.reply(response, 200, this.level, 'image/png');
    } else if (url === '/api/levels/0.heights') {
      this.reply(response, 200, this.heights, 'application/octet-stream');
    } else if (picture) this.reply(response, 200, picture, 'image/jpeg');
    else this.refuse(response, 404, 'not_found', 'there is no such thing');
  }

  file(url, response) {
    const name = path.join(
        this.pageFolder, url === '/' ? 'index.html' : path.normalize(url));
    if (!name.startsWith(this.pageFolder + path.sep) || !fs.existsSync(name)) {
      this.refuse(response, 404, 'not_found', 'there is no such file');
      return;
    }
    this.reply(response, 200, fs.readFileSync(name),
        TYPES[path.extname(name)] ?? 'application/octet-stream');
  }

  // Drives to the first waypoint of a route, as far as can be seen.
  begin(route) {
    this.current = route;
    this.route = { id: (this.route?.id ?? 0n) + 1n, name: route.name,
      state: routeMessages.RouteState.DRIVING, waypoint: 0,
      waypoints: route.waypoints.length, loop: route.loop,
      waypointName: route.waypoints[0].name, waitS: route.waypoints[0].waitS };
    ++this.routesRevision;
  }

  obey(method, body) {
    switch (method) {
      case 'Navigate': {
        const to = body.poses.at(-1);
        this.goal = { id: (this.goal?.id ?? 0n) + 1n,
          state: messages.GoalState.ACTIVE };
        this.goalPoses = body.poses;
        this.path = this.wayTo({ x: to.xM, y: to.yM });
        this.driven = 0;
        this.mode = 'driving';
        this.say('goal', `Goal ${this.goal.id} accepted.`);
        this.say('plan', `A way of ${this.toGo().toFixed(1)} m in 3 ms.`);
        return {};
      }
      case 'Cancel':
        if (this.goal) this.goal.state = messages.GoalState.CANCELLED;
        this.path = [];
        this.mode = 'idle';
        return {};
      case 'Pause': this.mode = 'paused'; return {};
      case 'Resume':
        this.mode = this.path.length > 0 ? 'driving' : 'idle';
        return {};
      case 'Stop':
        this.stopped = { why: body.why, sinceS: 1 };
        this.mode = 'stopped';
        return { survivesRestart: this.stopWarning === '',
          warning: this.stopWarning };
      case 'Release':
        this.stopped = undefined;
        this.mode = 'idle';
        return {};
      case 'Drive': return { leaseS: 0.3 };
      case 'PutZones':
        this.zones.push(...body.zones);
        ++this.zonesRevision;
        return { revision: this.zonesRevision, survivesRestart: true };
      case 'RemoveZones':
        this.zones = this.zones.filter(
            ({ name }) => !body.names.includes(name));
        ++this.zonesRevision;
        return { revision: this.zonesRevision };
      case 'PutRoutes':
        this.routes.push(...body.routes);
        ++this.routesRevision;
        return { revision: this.routesRevision, survivesRestart: true };
      case 'RemoveRoutes':
        this.routes = this.routes.filter(
            ({ name }) => !body.names.includes(name));
        ++this.routesRevision;
        return { revision: this.routesRevision };
      case 'RunRoute':
        this.begin(body.what.case === 'kept' ?
          this.routes.find(({ name }) => name === body.what.value) :
          body.what.value);
        return {};
      case 'ResumeRoute':
        this.route = { ...this.route, why: '',
          state: routeMessages.RouteState.DRIVING };
        return {};
      case 'CancelRoute':
        this.route = { ...this.route, why: 'somebody cancelled it',
          state: routeMessages.RouteState.CANCELLED };
        this.current = undefined;
        return {};
      case 'PutDocks':
        this.docks.push(...body.docks.map((dock) => body.here ?
          { ...dock, xM: this.pose.x, yM: this.pose.y,
            yawRad: this.pose.yaw } : dock));
        ++this.docksRevision;
        return { revision: this.docksRevision, survivesRestart: true };
      case 'RemoveDocks':
        this.docks = this.docks.filter(
            ({ name }) => !body.names.includes(name));
        ++this.docksRevision;
        return { revision: this.docksRevision };
      case 'Dock':
        this.docking = { id: 1n, dock: body.name,
          outcome: dockMessages.DockingOutcome.UNDER_WAY,
          state: dockMessages.DockingState.TO_STAGING };
        return {};
      case 'SetInitialPose': {
        const { xM, yM, yawRad } = body.mapFromBase;
        this.pose = { x: xM, y: yM, yaw: yawRad };
        return {};
      }
      case 'AddObstacle':
        this.obstacles.push({ name: `box-${this.obstacles.length + 1}`,
          x: body.xM, y: body.yM });
        return { name: this.obstacles.at(-1).name };
      case 'RemoveObstacle':
        this.obstacles =
            this.obstacles.filter((box) => box.name !== body.name);
        return {};
      default: return {};
    }
  }
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const agent = new MockAgent({ pageFolder: process.argv[2] ?? 'build/page' });
  console.log(await agent.listen(Number(process.argv[3] ?? 8090)));
}
