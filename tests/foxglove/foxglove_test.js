// The agent's live view as Foxglove's own client sees it: what is advertised,
// and every message by the schema that came with it. TREELINE_AGENT: the
// program.
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { after, before, test } from 'node:test';

import { parse } from '@foxglove/rosmsg';
import { MessageReader } from '@foxglove/rosmsg2-serialization';
import protocol from '@foxglove/ws-protocol';
import WebSocket from 'ws';

const { FoxgloveClient } = protocol;

let agent;
let address;
let log = '';

before(async () => {
  agent = spawn(process.env.TREELINE_AGENT, ['run', '--simulate', 'cafe',
    '--people=false', '--camera-hz', '2', '--listen', '127.0.0.1:0',
    '--http-listen', '127.0.0.1:0', '--foxglove-listen', '127.0.0.1:0'],
  { stdio: ['ignore', 'pipe', 'pipe'] });
  agent.stderr.on('data', (data) => { log += data; });
  await new Promise((resolve, reject) => {
    let said = '';
    agent.stdout.on('data', (data) => {
      said += data;
      address = /foxglove on (\S+)/.exec(said)?.[1];
      if (address && said.includes('driving')) resolve();
    });
    agent.once('exit', (code, signal) => reject(
      new Error(`treeline-agent ended with ${signal ?? code}: ${log}`)));
  });
});
after(() => agent?.kill('SIGKILL'));

// A client that subscribes to everything; messages(topic) waits for the first
// `count` messages of a topic.
class Viewer {
  static async open() {
    const viewer = new Viewer();
    const socket = new WebSocket(address, [FoxgloveClient.SUPPORTED_SUBPROTOCOL]);
    viewer.client = new FoxgloveClient({ ws: socket });
    viewer.topics = new Map();
    viewer.statuses = [];
    viewer.client.on('serverInfo', (info) => { viewer.info = info; });
    viewer.client.on('status', (status) => viewer.statuses.push(status));
    viewer.client.on('message', ({ subscriptionId, data }) => {
      const topic = viewer.bySubscription.get(subscriptionId);
      topic.messages.push(topic.reader.readMessage(data));
      topic.told?.();
    });
    viewer.bySubscription = new Map();
    await new Promise((resolve, reject) => {
      viewer.client.on('error', reject);
      viewer.client.on('advertise', (channels) => {
        for (const channel of channels) viewer.subscribe(channel);
        resolve();
      });
    });
    return viewer;
  }

  subscribe(channel) {
    const schema = parse(channel.schema, { ros2: true });
    const topic = { channel, messages: [], reader: new MessageReader(schema) };
    this.topics.set(channel.topic, topic);
    this.bySubscription.set(this.client.subscribe(channel.id), topic);
  }

  async messages(name, count = 1) {
    const topic = this.topics.get(name);
    while (topic.messages.length < count) {
      await new Promise((resolve) => { topic.told = resolve; });
    }
    return topic.messages;
  }
}

test('Foxglove is shown the robot, in the schemas of ROS 2', async () => {
  const viewer = await Viewer.open();
  assert.match(viewer.info.name, /^treeline-agent /);
  const [{ transforms }] = await viewer.messages('/tf');
  const place = transforms.find((t) => t.child_frame_id === 'base_link');
  assert.equal(place.header.frame_id, 'map');
  const [pose] = await viewer.messages('/pose');
  // The robot of the cafe starts at (1.6, 7.9).
  assert.ok(Math.abs(pose.pose.pose.position.x - 1.6) < 0.5, JSON.stringify(
    pose.pose.pose.position));
  assert.ok(Math.abs(pose.pose.pose.position.y - 7.9) < 0.5);
  assert.equal(place.transform.translation.x, pose.pose.pose.position.x);
  const [map] = await viewer.messages('/map');
  assert.equal(map.data.length, map.info.width * map.info.height);
  assert.ok(map.data.includes(100) && map.data.includes(0));
  const [scan] = await viewer.messages('/scan_points');
  assert.deepEqual(scan.fields.map((field) => field.name), ['x', 'y', 'z']);
  assert.ok(scan.width > 100, `${scan.width} points`);
  assert.equal(scan.data.length, scan.width * scan.point_step);
  const [picture] = await viewer.messages('/camera/color/image_raw/compressed');
  assert.equal(picture.format, 'jpeg');
  assert.deepEqual([...picture.data.slice(0, 2)], [0xff, 0xd8]);
  const [report] = await viewer.messages('/diagnostics');
  assert.ok(report.status.some((s) => s.name === 'treeline: localization'));
  const [line] = await viewer.messages('/rosout');
  assert.match(line.name, /^treeline\./);
  const [particles] = await viewer.messages('/particles');
  assert.ok(particles.width > 10, `${particles.width} particles`);
  for (const name of ['/local_costmap', '/cmd_vel', '/plan', '/band']) {
    await viewer.messages(name);
  }
  // It goes on, and the map is not told again.
  await viewer.messages('/pose', 10);
  assert.equal(viewer.topics.get('/map').messages.length, 1);
  assert.deepEqual(viewer.statuses, []);
  viewer.client.close();
});

test('who leaves may come again, and ends with the agent', async () => {
  const viewer = await Viewer.open();
  await viewer.messages('/map');
  const closed = new Promise((resolve) => { viewer.client.on('close', resolve); });
  agent.kill('SIGTERM');
  assert.equal((await closed).code, 1001);
});
