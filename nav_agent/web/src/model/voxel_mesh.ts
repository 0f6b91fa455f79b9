// An OctoMap as few rectangles: only faces that something may see, those of
// one height in a row as one. They are in order of height, so that the map is
// cut open at any height by drawing fewer of them.
//
// A face is left out where the neighbour is occupied, and below, where nobody
// looks from. What the cut opens is closed by `caps`: the upper faces of voxels
// with another one above.

import { heightColour, heightShare, shade } from './colours.js';
import type { Octomap } from './octomap.js';

export interface Faces {
  // 4 corners of each rectangle, 3 numbers a corner.
  positions: Float32Array;
  // 3 bytes a corner.
  colours: Uint8Array;
  rectangles: number;
}

export interface VoxelMesh {
  body: Faces;
  caps: Faces;
  resolution: number;
  // The lowest voxels' lower side (m).
  bottom: number;
  // Of each layer from the bottom: how many rectangles there are up to its end.
  bodyEnds: Uint32Array;
  capEnds: Uint32Array;
}

// More cells than this in the box around all voxels are not drawn.
const MOST_CELLS = 400e6;

interface Grid {
  // Cells, with one more around all of them.
  width: number;
  depth: number;
  layers: number;
  cells: Uint8Array;
  corner: [x: number, y: number, z: number];
}

function gridOf({ resolution, centres }: Octomap): Grid {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < centres.length; ++i) {
    low[i % 3] = Math.min(low[i % 3], centres[i]);
    high[i % 3] = Math.max(high[i % 3], centres[i]);
  }
  const size = low.map((value, axis) => centres.length === 0 ? 2 :
      Math.round((high[axis] - value) / resolution) + 3);
  const count = size[0] * size[1] * size[2];
  if (!(count <= MOST_CELLS)) {
    throw new Error(`the OctoMap is too large to draw: ${size.join(' x ')}`);
  }
  const cells = new Uint8Array(count);
  for (let i = 0; i < centres.length; i += 3) {
    const [x, y, z] = [0, 1, 2].map((axis) =>
        Math.round((centres[i + axis] - low[axis]) / resolution) + 1);
    cells[(z * size[1] + y) * size[0] + x] = 1;
  }
  const corner = low.map((value) => value - 1.5 * resolution);
  return {
    width: size[0], depth: size[1], layers: size[2], cells,
    corner: centres.length === 0 ? [0, 0, 0] :
        corner as [number, number, number],
  };
}

class FaceList {
  private readonly positions: number[] = [];
  private readonly colours: number[] = [];

  get count(): number {
    return this.positions.length / 12;
  }

  add(corners: number[], colour: readonly number[]): void {
    this.positions.push(...corners);
    for (let i = 0; i < 4; ++i) this.colours.push(...colour);
  }

  faces(): Faces {
    return {
      positions: new Float32Array(this.positions),
      colours: new Uint8Array(this.colours),
      rectangles: this.count,
    };
  }
}

// Calls `run(begin, end)` for each longest run of cells that `has`.
function runs(count: number, has: (i: number) => boolean,
              run: (begin: number, end: number) => void): void {
  let begin = -1;
  for (let i = 0; i <= count; ++i) {
    const isIn = i < count && has(i);
    if (isIn && begin < 0) begin = i;
    if (!isIn && begin >= 0) {
      run(begin, i);
      begin = -1;
    }
  }
}

// Light comes from above and from the front left: no two sides of a wall are
// alike, and the tops are the lightest.
const LIGHT = [['front', 0.9], ['left', 0.78], ['right', 0.64], ['back', 0.55],
] as const;

export function meshOf(map: Octomap): VoxelMesh {
  const grid = gridOf(map);
  const { width, depth, layers, cells, corner } = grid;
  const r = map.resolution;
  const body = new FaceList();
  const caps = new FaceList();
  const bodyEnds = new Uint32Array(layers - 2);
  const capEnds = new Uint32Array(layers - 2);
  const rowStep = width;
  const layerStep = width * depth;
  for (let z = 1; z + 1 < layers; ++z) {
    const z0 = corner[2] + z * r;
    const z1 = z0 + r;
    const colour =
        heightColour(heightShare((z - 0.5) / Math.max(1, layers - 2)));
    const lit = new Map(LIGHT.map(
        ([side, share]) => [side, shade(colour, share)] as const));
    const layer = z * layerStep;
    for (let y = 1; y + 1 < depth; ++y) {
      const row = layer + y * rowStep;
      const y0 = corner[1] + y * r;
      const y1 = y0 + r;
      const top = (list: FaceList, isCovered: number): void =>
        runs(width, (x) => cells[row + x] === 1 &&
              cells[row + x + layerStep] === isCovered, (begin, end) => {
          const x0 = corner[0] + begin * r;
          const x1 = corner[0] + end * r;
          list.add([x0, y0, z1, x1, y0, z1, x1, y1, z1, x0, y1, z1], colour);
        });
      top(body, 0);
      top(caps, 1);
      for (const side of [-1, 1]) {
        runs(width, (x) => cells[row + x] === 1 &&
              cells[row + x + side * rowStep] === 0, (begin, end) => {
          const x0 = corner[0] + begin * r;
          const x1 = corner[0] + end * r;
          const at = side < 0 ? y0 : y1;
          const [a, b] = side < 0 ? [x0, x1] : [x1, x0];
          body.add([a, at, z0, b, at, z0, b, at, z1, a, at, z1],
              lit.get(side < 0 ? 'front' : 'back')!);
        });
      }
    }
    for (let x = 1; x + 1 < width; ++x) {
      const column = layer + x;
      for (const side of [-1, 1]) {
        runs(depth, (y) => cells[column + y * rowStep] === 1 &&
              cells[column + y * rowStep + side] === 0, (begin, end) => {
          const y0 = corner[1] + begin * r;
          const y1 = corner[1] + end * r;
          const at = corner[0] + (side < 0 ? x : x + 1) * r;
          const [a, b] = side < 0 ? [y1, y0] : [y0, y1];
          body.add([at, a, z0, at, b, z0, at, b, z1, at, a, z1],
              lit.get(side < 0 ? 'left' : 'right')!);
        });
      }
    }
    bodyEnds[z - 1] = body.count;
    capEnds[z - 1] = caps.count;
  }
  return {
    body: body.faces(), caps: caps.faces(), resolution: r,
    bottom: corner[2] + r, bodyEnds, capEnds,
  };
}

// What to draw of a mesh that is cut open at `height` (m; Infinity: not at
// all): voxels whose centre is below.
export function drawnBelow(mesh: VoxelMesh, height: number): {
  body: number; caps: [begin: number, end: number];
} {
  const all = mesh.bodyEnds.length;
  const layers = Math.max(0, Math.min(
      all, Math.floor((height - mesh.bottom) / mesh.resolution + 0.5)));
  if (layers === 0) return { body: 0, caps: [0, 0] };
  const begin = layers > 1 ? mesh.capEnds[layers - 2] : 0;
  return {
    body: mesh.bodyEnds[layers - 1],
    caps: layers === all ? [0, 0] : [begin, mesh.capEnds[layers - 1]],
  };
}
