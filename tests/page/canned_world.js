// A small cafe for the page's tests: a lower floor, a slope to a terrace, stairs
// beside it, walls, tables and a ceiling. Octree cells of 0.1 m.

import zlib from 'node:zlib';

export const RESOLUTION_M = 0.1;
export const WIDTH = 130;
export const DEPTH = 100;
const TERRACE_M = 0.5;
const CEILING_M = 3.0;

const RAMP = { x0: 4.2, x1: 9.2, y0: 7.6, y1: 9.6 };
const STAIRS = { x0: 8.0, x1: 9.2, y0: 5.4, y1: 7.4 };
const TERRACE = { x0: 9.2, x1: 12.8, y0: 5.2, y1: 9.8 };
const WALLS = [
  { x0: 0, x1: 13, y0: 0, y1: 0.2 }, { x0: 0, x1: 13, y0: 9.8, y1: 10 },
  { x0: 0, x1: 0.2, y0: 0, y1: 10 }, { x0: 12.8, x1: 13, y0: 0, y1: 10 },
  { x0: 4.6, x1: 4.8, y0: 0, y1: 2.6 }, { x0: 4.6, x1: 4.8, y0: 4.2, y1: 5.4 },
];
const TABLES = [
  [2.2, 7.6], [2.2, 2.2], [7.2, 2.0], [10.4, 2.2], [7.0, 4.6], [10.9, 8.6],
];

const isIn = (box, x, y) =>
  x >= box.x0 && x < box.x1 && y >= box.y0 && y < box.y1;
const isWall = (x, y) => WALLS.some((wall) => isIn(wall, x, y));
const isTable = (x, y) => TABLES.some(([tx, ty]) =>
  Math.abs(x - tx) < 0.45 && Math.abs(y - ty) < 0.45);

export function groundAt(x, y) {
  if (isIn(RAMP, x, y)) return TERRACE_M * (x - RAMP.x0) / (RAMP.x1 - RAMP.x0);
  if (isIn(STAIRS, x, y)) {
    return Math.ceil(4 * (x - STAIRS.x0) / (STAIRS.x1 - STAIRS.x0)) *
      TERRACE_M / 4;
  }
  return isIn(TERRACE, x, y) ? TERRACE_M : 0;
}

function isFree(x, y) {
  return !isWall(x, y) && !isTable(x, y) && !isIn(STAIRS, x, y) &&
    !(isIn({ ...RAMP, y1: RAMP.y0 + 0.1 }, x, y));
}

const centre = (cell) => (cell + 0.5) * RESOLUTION_M;

export function octomap() {
  const points = [];
  const column = (x, y, from, to) => {
    for (let z = from; z < to - 1e-6; z += RESOLUTION_M) {
      points.push(x, y, z + RESOLUTION_M / 2);
    }
  };
  for (let row = 0; row < DEPTH; ++row) {
    for (let cell = 0; cell < WIDTH; ++cell) {
      const [x, y] = [centre(cell), centre(row)];
      const ground = surfaceAt(x, y);
      if (isWall(x, y)) {
        column(x, y, -0.1, CEILING_M);
        continue;
      }
      column(x, y, -0.1, ground);
      if (isTable(x, y)) column(x, y, ground + 0.7, ground + 0.8);
      column(x, y, CEILING_M, CEILING_M + RESOLUTION_M);
    }
  }
  for (const [x, y] of TABLES) column(x, y, groundAt(x, y), groundAt(x, y) + 0.7);
  const bytes = Buffer.alloc(12 + 4 * points.length);
  bytes.write('TLVX');
  bytes.writeUInt32LE(points.length / 3, 4);
  bytes.writeFloatLE(RESOLUTION_M, 8);
  points.forEach((value, i) => bytes.writeFloatLE(value, 12 + 4 * i));
  return bytes;
}

// As voxels have it.
const surfaceAt = (x, y) =>
  Math.round(groundAt(x, y) / RESOLUTION_M) * RESOLUTION_M;

export function heights() {
  const bytes = Buffer.alloc(12 + 4 * WIDTH * DEPTH);
  bytes.write('TLVH');
  bytes.writeUInt32LE(WIDTH, 4);
  bytes.writeUInt32LE(DEPTH, 8);
  for (let row = 0; row < DEPTH; ++row) {
    for (let cell = 0; cell < WIDTH; ++cell) {
      const [x, y] = [centre(cell), centre(row)];
      bytes.writeFloatLE(
          isWall(x, y) ? NaN : surfaceAt(x, y), 12 + 4 * (row * WIDTH + cell));
    }
  }
  return bytes;
}

function chunk(type, data) {
  const body = Buffer.concat([Buffer.from(type), data]);
  const out = Buffer.alloc(body.length + 8);
  out.writeUInt32BE(data.length, 0);
  body.copy(out, 4);
  out.writeUInt32BE(crc32(body), body.length + 4);
  return out;
}

function crc32(bytes) {
  let crc = ~0;
  for (const byte of bytes) {
    crc ^= byte;
    for (let bit = 0; bit < 8; ++bit) {
      crc = (crc >>> 1) ^ (crc & 1 ? 0xedb88320 : 0);
    }
  }
  return ~crc >>> 0;
}

// Grey pixels, row 0 at the top.
export function png(width, height, shade) {
  const rows = Buffer.alloc(height * (width + 1));
  for (let y = 0; y < height; ++y) {
    for (let x = 0; x < width; ++x) rows[y * (width + 1) + 1 + x] = shade(x, y);
  }
  const head = Buffer.alloc(13);
  head.writeUInt32BE(width, 0);
  head.writeUInt32BE(height, 4);
  head.set([8, 0, 0, 0, 0], 8);
  return Buffer.concat([
    Buffer.from([0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a]),
    chunk('IHDR', head), chunk('IDAT', zlib.deflateSync(rows)),
    chunk('IEND', Buffer.alloc(0)),
  ]);
}

export function levelPicture() {
  return png(WIDTH, DEPTH, (column, fromTop) => {
    const [x, y] = [centre(column), centre(DEPTH - 1 - fromTop)];
    return isFree(x, y) ? 255 : 0;
  });
}

// What a laser at (x, y) sees: ends of its beams on walls and tables' legs.
export function scanFrom(x, y, beams = 360) {
  const ends = [];
  for (let beam = 0; beam < beams; ++beam) {
    const angle = (beam / beams) * 2 * Math.PI;
    for (let range = 0.1; range < 14; range += 0.04) {
      const [bx, by] =
          [x + range * Math.cos(angle), y + range * Math.sin(angle)];
      const isHit = isWall(bx, by) || TABLES.some(([tx, ty]) =>
        Math.hypot(bx - tx, by - ty) < 0.08) ||
        groundAt(bx, by) > groundAt(x, y) + 0.35;
      if (isHit) {
        ends.push(bx, by);
        break;
      }
    }
  }
  return ends;
}

export function costmapAround(x, y, z, seen) {
  const [resolution, side] = [0.05, 80];
  const origin = [x - 2, y - 2];
  const cells = Buffer.alloc(side * side);
  for (let row = 0; row < side; ++row) {
    for (let column = 0; column < side; ++column) {
      const cx = origin[0] + (column + 0.5) * resolution;
      const cy = origin[1] + (row + 0.5) * resolution;
      const isBox = seen.some((box) =>
        Math.abs(cx - box.x) < 0.25 && Math.abs(cy - box.y) < 0.25);
      cells[row * side + column] = isBox ? 2 : isFree(cx, cy) ? 0 : 1;
    }
  }
  return { originXM: origin[0], originYM: origin[1], resolutionM: resolution,
    width: side, height: side, heightM: z, cells };
}
