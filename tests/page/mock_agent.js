// An agent that a test plays: it speaks the HTTP interface of treeline-agent
// over a canned world, moves its robot along straight lines, and remembers what
// it was asked. As a program, `node mock_agent.js PAGE PORT`, for work on the
// page.

import fs from 'node:fs';
import http from 'node:http';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

import * as world from './canned_world.js';

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

export class MockAgent {
  constructor({ pageFolder, picture = null, simulated = true }) {
    this.pageFolder = path.resolve(pageFolder);
    this.picture = picture;
    this.simulated = simulated;
    // What was asked: {path, body}.
    this.asked = [];
    // Path -> status and message with which it is answered.
    this.refusals = new Map();
    this.pose = { x: 2.0, y: 4.9, yaw: 0 };
    this.mode = 'idle';
    this.cause = 'none';
    this.advice = '';
    this.lost = { probability: 0.04, state: 'localized', reason: 'none' };
    this.goal = null;
    this.path = [];
    this.driven = 0;
    this.obstacles = [];
    this.fix = null;
    this.events = [];
    this.time = 12;
    this.devices = ['laser', 'odometry', 'base', 'camera', 'server'].map(
        (name) => ({ name, state: 'running', cause: '' }));
    this.streams = new Set();
    this.octomap = world.octomap();
    this.level = world.levelPicture();
    this.heights = world.heights();
  }

  async listen(port = 0) {
    this.server = http.createServer((request, response) =>
      this.answer(request, response));
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

  // The connection stays, and nothing comes any more.
  fallSilent() {
    clearInterval(this.timer);
  }

  // The last body that was sent to `path`.
  lastAsked(path) {
    return this.asked.filter((entry) => entry.path === path).at(-1)?.body;
  }

  // ---- the robot ----

  say(kind, text) {
    const event = { number: this.events.length + 1, time_s: this.time, kind,
      text };
    this.events.push(event);
    this.send('event', event);
  }

  tick(seconds) {
    this.time += seconds;
    if (this.mode === 'driving') this.drive(seconds);
    this.send('state', this.state());
    if (Math.round(this.time * 10) % 3 === 0) this.send('scene', this.scene());
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
      this.pose.yaw = this.goal.poses.at(-1).yaw;
      this.goal.state = 'succeeded';
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
    const height_m = world.groundAt(x, y);
    return {
      time_s: this.time, mode: this.mode, cause: this.cause, cause_text: '',
      advice: this.advice,
      pose: { x, y, yaw, level: 0, height_m, std_m: 0.06, std_rad: 0.03 },
      lost: this.lost,
      command: { forward_mps: this.mode === 'driving' ? 0.58 : 0,
        yaw_rate_radps: 0 },
      goal: this.goal === null ? null : {
        ...this.goal, cause: 'none', why: '', to_go_m: this.toGo(),
        driven_m: this.driven, replans: 1, recoveries: 0 },
      fix: this.fix, devices: this.devices,
      truth: this.simulated ?
        { x: x + 0.05, y: y - 0.04, yaw: yaw + 0.03, height_m } : null,
      missed_deadlines: 0, steps: Math.round(this.time * 40),
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
      path: route,
      bubbles: route.slice(2, 26).filter((_, i) => i % 3 === 0)
          .map(([bx, by, bz]) => [bx, by, bz, 0.42]),
      tree: route.length === 0 ? [] : this.tree(),
      scan: world.scanFrom(x, y), particles,
      blockages: this.obstacles.map((box) => [box.x, box.y, 0.45, 0]),
      costmap: world.costmapAround(
          x, y, world.groundAt(x, y), this.obstacles),
      obstacles: this.obstacles,
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

  // ---- HTTP ----

  send(type, data) {
    for (const response of this.streams) {
      response.write(`event: ${type}\ndata: ${JSON.stringify(data)}\n\n`);
    }
  }

  answer(request, response) {
    const url = new URL(request.url, 'http://agent');
    for (const [name, value] of Object.entries(HEADERS)) {
      response.setHeader(name, value);
    }
    if (request.method === 'POST') this.command(url.pathname, request, response);
    else if (url.pathname.startsWith('/api/')) this.give(url.pathname, response);
    else this.file(url.pathname, response);
  }

  reply(response, status, body, type = 'application/json') {
    response.writeHead(status, { 'Content-Type': type });
    response.end(Buffer.isBuffer(body) ? body : JSON.stringify(body));
  }

  refuse(response, status, code, message) {
    this.reply(response, status, { error: { code, message } });
  }

  info() {
    return {
      version: '0.1.0', robot: { front_m: 0.3, rear_m: 0.3, half_width_m: 0.31 },
      map: { name: 'cafe', levels: [{ index: 0, width: world.WIDTH,
        height: world.DEPTH, resolution_m: world.RESOLUTION_M,
        origin: [0, 0, 0], min_height_m: 0, max_height_m: 0.5 }] },
      simulated: this.simulated, world: this.simulated ? 'cafe' : '',
      places: this.simulated ? ['terrace', 'entrance', 'kitchen'] : [],
      server: '127.0.0.1:50051',
    };
  }

  give(url, response) {
    const picture = { 'api/camera.jpg': this.picture,
      'api/query.jpg': this.fix && this.picture }[url.slice(1)];
    if (url === '/api/info') this.reply(response, 200, this.info());
    else if (url === '/api/state') this.reply(response, 200, this.state());
    else if (url === '/api/scene') this.reply(response, 200, this.scene());
    else if (url === '/api/octomap') {
      this.reply(response, 200, this.octomap, 'application/octet-stream');
    } else if (url === '/api/levels/0.png') {
      this.reply(response, 200, this.level, 'image/png');
    } else if (url === '/api/levels/0.heights') {
      this.reply(response, 200, this.heights, 'application/octet-stream');
    } else if (url === '/api/stream') this.stream(response);
    else if (picture) this.reply(response, 200, picture, 'image/jpeg');
    else this.refuse(response, 404, 'not_found', 'there is no such thing');
  }

  stream(response) {
    response.writeHead(200, { 'Content-Type': 'text/event-stream',
      'Cache-Control': 'no-store' });
    this.streams.add(response);
    response.on('close', () => this.streams.delete(response));
    for (const event of this.events) {
      response.write(`event: event\ndata: ${JSON.stringify(event)}\n\n`);
    }
    response.write(`event: state\ndata: ${JSON.stringify(this.state())}\n\n`);
    response.write(`event: scene\ndata: ${JSON.stringify(this.scene())}\n\n`);
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

  async command(url, request, response) {
    let text = '';
    for await (const part of request) text += part;
    if (request.headers['x-treeline'] !== '1' ||
        request.headers['content-type'] !== 'application/json') {
      this.refuse(response, 403, 'permission_denied', 'not from the page');
      return;
    }
    const body = JSON.parse(text);
    this.asked.push({ path: url, body });
    const refusal = this.refusals.get(url);
    if (refusal !== undefined) {
      this.refuse(response, refusal.status, 'refused', refusal.message);
      return;
    }
    this.reply(response, 200, { ok: true, ...this.obey(url, body) });
  }

  obey(url, body) {
    switch (url) {
      case '/api/goal':
        this.goal = { id: (this.goal?.id ?? 0) + 1, state: 'active',
          poses: body.poses };
        this.path = this.wayTo(body.poses.at(-1));
        this.driven = 0;
        this.mode = 'driving';
        this.say('goal', `Goal ${this.goal.id} accepted.`);
        this.say('plan', `A way of ${this.toGo().toFixed(1)} m in 3 ms.`);
        return { id: this.goal.id };
      case '/api/cancel':
        if (this.goal) this.goal.state = 'cancelled';
        this.path = [];
        this.mode = 'idle';
        return {};
      case '/api/pause': this.mode = 'paused'; return {};
      case '/api/resume':
        this.mode = this.path.length > 0 ? 'driving' : 'idle';
        return {};
      case '/api/initial-pose':
        this.pose = { x: body.x, y: body.y, yaw: body.yaw };
        return {};
      case '/api/sim/obstacle':
        this.obstacles.push({ name: `box-${this.obstacles.length + 1}`,
          x: body.x, y: body.y });
        return { name: this.obstacles.at(-1).name };
      case '/api/sim/remove-obstacle':
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
