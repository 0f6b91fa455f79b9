// A level's traversable map, laid on its ground.

import {
  BufferAttribute, BufferGeometry, CanvasTexture, Group, LinearFilter, Mesh,
  MeshBasicMaterial, NearestFilter, Plane, Vector3,
} from 'three';

import type { HeightField } from '../../model/height_field.js';
import type { Theme } from '../theme.js';

// Above the surface of the voxels that it lies on (m).
const LIFT_M = 0.02;
// Neighbouring cells that differ by more are a step, not a slope (m).
const STEP_M = 0.12;

// Corner heights of a grid of cells: the highest of the cells around a corner
// that belong to the same ground as `height`. So no voxel of a slope looks out.
function cornerHeight(field: HeightField, heights: Float32Array, column: number,
                      row: number, height: number): number {
  const { width, height: rows } = field.level;
  let highest = height;
  for (const y of [row - 1, row]) {
    for (const x of [column - 1, column]) {
      if (x < 0 || y < 0 || x >= width || y >= rows) continue;
      const other = heights[y * width + x];
      if (Number.isNaN(other) || Math.abs(other - height) > STEP_M) continue;
      highest = Math.max(highest, other);
    }
  }
  return highest;
}

class GroundMesh {
  private readonly positions: number[] = [];
  private readonly uvs: number[] = [];

  constructor(private readonly field: HeightField) {}

  // Cells from column `begin` to before `end`; heights of the corners, counter-
  // clockwise from the lower left.
  add(begin: number, end: number, row: number, corners: number[]): void {
    const { width, height } = this.field.level;
    const at = [[begin, row], [end, row], [end, row + 1], [begin, row + 1]];
    at.forEach(([column, line], i) => {
      const point = this.field.toMap(column, line);
      this.positions.push(point.x, point.y, corners[i] + LIFT_M);
      this.uvs.push(column / width, line / height);
    });
  }

  geometry(): BufferGeometry {
    const count = this.positions.length / 12;
    const indices = new Uint32Array(6 * count);
    for (let i = 0; i < count; ++i) {
      indices.set([0, 1, 2, 0, 2, 3].map((corner) => 4 * i + corner), 6 * i);
    }
    const geometry = new BufferGeometry();
    geometry.setAttribute(
        'position', new BufferAttribute(new Float32Array(this.positions), 3));
    geometry.setAttribute(
        'uv', new BufferAttribute(new Float32Array(this.uvs), 2));
    geometry.setIndex(new BufferAttribute(indices, 1));
    return geometry;
  }
}

export function groundGeometry(field: HeightField): BufferGeometry {
  const { width, height: rows } = field.level;
  const mesh = new GroundMesh(field);
  const { heights } = field;
  if (heights === null) {
    const z = field.typical;
    for (let row = 0; row < rows; ++row) mesh.add(0, width, row, [z, z, z, z]);
    return mesh.geometry();
  }
  for (let row = 0; row < rows; ++row) {
    // Cells that are flat and of one height, as one.
    let begin = -1;
    let level = 0;
    const flush = (end: number): void => {
      if (begin >= 0) mesh.add(begin, end, row, [level, level, level, level]);
      begin = -1;
    };
    for (let column = 0; column < width; ++column) {
      const height = heights[row * width + column];
      if (Number.isNaN(height)) {
        flush(column);
        continue;
      }
      const corners = [[0, 0], [1, 0], [1, 1], [0, 1]].map(([dx, dy]) =>
        cornerHeight(field, heights, column + dx, row + dy, height));
      const isFlat = corners.every((corner) => corner === corners[0]);
      if (!isFlat || corners[0] !== level) flush(column);
      if (!isFlat) {
        mesh.add(column, column + 1, row, corners);
      } else if (begin < 0) {
        begin = column;
        level = corners[0];
      }
    }
    flush(width);
  }
  return mesh.geometry();
}

// The picture in the theme's colours; unknown ground is see-through.
function paint(picture: ImageBitmap, theme: Theme): HTMLCanvasElement {
  const canvas = document.createElement('canvas');
  canvas.width = picture.width;
  canvas.height = picture.height;
  const context = canvas.getContext('2d', { willReadFrequently: true });
  if (context === null) return canvas;
  context.drawImage(picture, 0, 0);
  const image = context.getImageData(0, 0, canvas.width, canvas.height);
  for (let i = 0; i < image.data.length; i += 4) {
    const value = image.data[i];
    const isKnown = value > 220 || value < 80;
    const colour = value > 220 ? theme.free : theme.occupied;
    image.data.set([...colour, isKnown ? 255 : 0], i);
  }
  context.putImageData(image, 0, 0);
  return canvas;
}

interface Level {
  mesh: Mesh<BufferGeometry, MeshBasicMaterial>;
  picture: ImageBitmap;
}

export class GroundLayer {
  readonly object = new Group();
  private levels = new Map<number, Level>();
  // What is above is cut off, as the voxels are.
  private readonly cut = new Plane(new Vector3(0, 0, -1), 1e6);

  clear(): void {
    for (const { mesh, picture } of this.levels.values()) {
      this.object.remove(mesh);
      mesh.geometry.dispose();
      mesh.material.map?.dispose();
      mesh.material.dispose();
      picture.close();
    }
    this.levels.clear();
  }

  add(field: HeightField, picture: ImageBitmap, theme: Theme): void {
    const material = new MeshBasicMaterial({
      transparent: true, alphaTest: 0.5, polygonOffset: true,
      polygonOffsetFactor: -1, polygonOffsetUnits: -2,
      clippingPlanes: [this.cut],
    });
    const mesh = new Mesh(groundGeometry(field), material);
    this.object.add(mesh);
    this.levels.set(field.level.index, { mesh, picture });
    this.paint(theme);
  }

  paint(theme: Theme): void {
    for (const { mesh, picture } of this.levels.values()) {
      mesh.material.map?.dispose();
      const texture = new CanvasTexture(paint(picture, theme));
      texture.magFilter = NearestFilter;
      texture.minFilter = LinearFilter;
      texture.generateMipmaps = false;
      mesh.material.map = texture;
      mesh.material.needsUpdate = true;
    }
  }

  cutAt(height: number): void {
    this.cut.constant = Math.min(1e6, height + LIFT_M);
  }

  shownLevels(): number {
    return [...this.levels.values()].filter(({ mesh }) => mesh.visible).length;
  }

  // The shown level and those below it.
  show(level: number): void {
    for (const [index, { mesh }] of this.levels) {
      mesh.visible = index <= level;
    }
  }
}
