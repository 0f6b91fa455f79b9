// MCAP files of ours, as @mcap/core reads them: by the index and as a stream,
// with every compression, and the messages by their schemas. Run by ctest with
// TREELINE_MCAP_SAMPLE naming the program of mcap_sample.cc.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, test } from 'node:test';

import { parse } from '@foxglove/rosmsg';
import { MessageReader } from '@foxglove/rosmsg2-serialization';
import { McapIndexedReader, McapStreamReader } from '@mcap/core';
import { decompress as unpackZstd } from 'fzstd';
import lz4 from 'lz4js';

const COUNT = 200;
const START = 1700000000000000000n;
const INTERVAL = 10000000n;

const unpack = {
  lz4: (bytes, size) => lz4.decompress(bytes, Number(size)),
  zstd: (bytes, size) => unpackZstd(bytes, new Uint8Array(Number(size))),
};

const folder = mkdtempSync(join(tmpdir(), 'treeline-mcap-'));
after(() => rmSync(folder, { recursive: true }));

function sample(packing) {
  const path = join(folder, `${packing}.mcap`);
  execFileSync(process.env.TREELINE_MCAP_SAMPLE, [packing, path]);
  return readFileSync(path);
}

// What McapIndexedReader reads from; counts what it asked for.
class Bytes {
  constructor(buffer) {
    this.buffer = buffer;
    this.read_ = 0;
  }

  async size() { return BigInt(this.buffer.length); }

  async read(offset, size) {
    assert.ok(offset + size <= BigInt(this.buffer.length));
    this.read_ += Number(size);
    return new Uint8Array(
      this.buffer.subarray(Number(offset), Number(offset + size)));
  }
}

function readersOf(reader) {
  const readers = new Map();
  for (const [id, channel] of reader.channelsById) {
    const schema = reader.schemasById.get(channel.schemaId);
    assert.equal(schema.encoding, 'ros2msg');
    assert.equal(channel.messageEncoding, 'cdr');
    const text = new TextDecoder().decode(schema.data);
    readers.set(id, {
      topic: channel.topic,
      type: schema.name,
      read: new MessageReader(parse(text, { ros2: true })),
    });
  }
  return readers;
}

for (const packing of ['none', 'lz4', 'zstd']) {
  test(`${packing}: by the index, decoded by its schemas`, async () => {
    const bytes = new Bytes(sample(packing));
    const reader = await McapIndexedReader.Initialize(
      { readable: bytes, decompressHandlers: unpack });
    assert.equal(reader.header.profile, 'ros2');
    assert.ok(reader.chunkIndexes.length > 5);
    assert.equal(reader.statistics.messageCount, BigInt(3 * COUNT));
    assert.equal(reader.statistics.messageStartTime, START);
    assert.equal(reader.statistics.messageEndTime,
      START + INTERVAL * BigInt(COUNT - 1) + 2n);
    const readers = readersOf(reader);
    assert.deepEqual(
      new Map([...readers.values()].map(({ topic, type }) => [topic, type])),
      new Map([
        ['/scan', 'sensor_msgs/msg/LaserScan'],
        ['/odom', 'nav_msgs/msg/Odometry'],
        ['/tf', 'tf2_msgs/msg/TFMessage'],
      ]));
    const seen = { '/scan': 0, '/odom': 0, '/tf': 0 };
    let last = 0n;
    for await (const message of reader.readMessages({ validateCrcs: true })) {
      assert.ok(message.logTime >= last);
      last = message.logTime;
      const { topic, read } = readers.get(message.channelId);
      const i = seen[topic]++;
      assert.equal(message.sequence, i);
      const value = read.readMessage(message.data);
      const header = topic === '/tf' ? value.transforms[0].header
        : value.header;
      assert.equal(
        BigInt(header.stamp.sec) * 1000000000n + BigInt(header.stamp.nanosec),
        START + INTERVAL * BigInt(i));
      if (topic === '/scan') {
        assert.equal(header.frame_id, 'laser');
        assert.equal(value.ranges.length, 90);
        assert.equal(value.ranges[7], i + 7 / 4);
      } else if (topic === '/odom') {
        assert.equal(value.child_frame_id, 'base_link');
        assert.equal(value.pose.pose.position.x, i / 2);
        assert.equal(value.pose.pose.orientation.w, 1);
        assert.equal(value.pose.covariance[35], 0.25);
        assert.equal(value.twist.twist.angular.z, -1);
      } else {
        assert.equal(value.transforms[0].child_frame_id, 'odom');
        assert.equal(value.transforms[0].transform.translation.y, i);
      }
    }
    assert.deepEqual(seen, { '/scan': COUNT, '/odom': COUNT, '/tf': COUNT });
  });

  test(`${packing}: one topic of a moment reads a part of the file`,
    async () => {
      const bytes = new Bytes(sample(packing));
      const reader = await McapIndexedReader.Initialize(
        { readable: bytes, decompressHandlers: unpack });
      bytes.read_ = 0;
      const times = [];
      for await (const message of reader.readMessages({
        topics: ['/odom'],
        startTime: START + 100n * INTERVAL,
        endTime: START + 102n * INTERVAL + 1n,
      })) {
        times.push(message.logTime);
      }
      assert.deepEqual(times,
        [100n, 101n, 102n].map((i) => START + i * INTERVAL + 1n));
      assert.ok(bytes.read_ < bytes.buffer.length / 2);
    });

  test(`${packing}: as a stream, with all checksums`, () => {
    const reader = new McapStreamReader(
      { decompressHandlers: unpack, validateCrcs: true });
    reader.append(sample(packing));
    const kinds = {};
    for (let record; (record = reader.nextRecord());) {
      kinds[record.type] = (kinds[record.type] ?? 0) + 1;
    }
    assert.ok(reader.done());
    assert.equal(reader.bytesRemaining(), 0);
    assert.equal(kinds.Message, 3 * COUNT);
    assert.equal(kinds.Header, 1);
    assert.equal(kinds.Footer, 1);
    assert.equal(kinds.Statistics, 1);
  });
}
