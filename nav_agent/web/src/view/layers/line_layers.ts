// What is drawn with points, lines and ribbons: scan, particles, tree, path.

import {
  BufferAttribute, BufferGeometry, DoubleSide, DynamicDrawUsage, LineBasicMaterial,
  LineSegments, Mesh, MeshBasicMaterial, Points, PointsMaterial,
} from 'three';

import type { HeightField } from '../../model/height_field.js';

// A geometry whose corners change with each picture; it grows as needed.
class Corners {
  readonly geometry = new BufferGeometry();
  private attribute = new BufferAttribute(new Float32Array(0), 3);

  // Room for `count` corners, of which all are drawn.
  take(count: number): Float32Array {
    if (this.attribute.count < count) {
      this.attribute =
          new BufferAttribute(new Float32Array(3 * 2 * count), 3);
      this.attribute.setUsage(DynamicDrawUsage);
      this.geometry.dispose();
      this.geometry.setAttribute('position', this.attribute);
    }
    this.geometry.setDrawRange(0, count);
    this.attribute.needsUpdate = true;
    return this.attribute.array as Float32Array;
  }
}

// At the height of the laser above its ground (m).
const SCAN_LIFT_M = 0.35;

export class ScanLayer {
  private readonly corners = new Corners();
  readonly material = new PointsMaterial({ size: 4, sizeAttenuation: false });
  readonly object = new Points(this.corners.geometry, this.material);

  constructor() {
    this.object.frustumCulled = false;
  }

  set(scan: Float32Array, groundZ: number): void {
    const count = scan.length / 2;
    const to = this.corners.take(count);
    for (let i = 0; i < count; ++i) {
      to.set([scan[2 * i], scan[2 * i + 1], groundZ + SCAN_LIFT_M], 3 * i);
    }
  }
}

export class ParticleLayer {
  private readonly corners = new Corners();
  readonly material =
      new LineBasicMaterial({ transparent: true, opacity: 0.75 });
  readonly object = new LineSegments(this.corners.geometry, this.material);

  constructor() {
    this.object.frustumCulled = false;
  }

  // A dart for each: shaft and two barbs.
  set(particles: Float32Array, ground: HeightField, otherwise: number): void {
    const count = particles.length / 3;
    const to = this.corners.take(6 * count);
    for (let i = 0; i < count; ++i) {
      const [x, y, yaw] = particles.subarray(3 * i, 3 * i + 3);
      const z = ground.atOr(x, y, otherwise) + 0.06;
      const tip = [x + 0.2 * Math.cos(yaw), y + 0.2 * Math.sin(yaw), z];
      const barb = (turn: number): number[] => [
        tip[0] + 0.07 * Math.cos(yaw + turn),
        tip[1] + 0.07 * Math.sin(yaw + turn), z,
      ];
      to.set([x, y, z, ...tip, ...tip, ...barb(2.6), ...tip, ...barb(-2.6)],
          18 * i);
    }
  }
}

export class TreeLayer {
  private readonly corners = new Corners();
  readonly material =
      new LineBasicMaterial({ transparent: true, opacity: 0.55 });
  readonly object = new LineSegments(this.corners.geometry, this.material);

  constructor() {
    this.object.frustumCulled = false;
  }

  set(edges: Float32Array, ground: HeightField, otherwise: number): void {
    const count = edges.length / 2;
    const to = this.corners.take(count);
    for (let i = 0; i < count; ++i) {
      const x = edges[2 * i];
      const y = edges[2 * i + 1];
      to.set([x, y, ground.atOr(x, y, otherwise) + 0.05], 3 * i);
    }
  }
}

// A ribbon of `width` along points (x, y, z, ...) of `step` numbers each; its
// triangles' corners.
export function ribbon(
    points: Float32Array, step: number, width: number, lift: number):
    Float32Array {
  const count = Math.floor(points.length / step);
  const out = new Float32Array(Math.max(0, count - 1) * 18);
  const side = (i: number): [number, number] => {
    const a = Math.max(0, i - 1) * step;
    const b = Math.min(count - 1, i + 1) * step;
    const dx = points[b] - points[a];
    const dy = points[b + 1] - points[a + 1];
    const length = Math.hypot(dx, dy) || 1;
    return [(-dy / length) * width / 2, (dx / length) * width / 2];
  };
  for (let i = 0; i + 1 < count; ++i) {
    const corner = (k: number, sign: number): number[] => {
      const [sx, sy] = side(k);
      const at = k * step;
      return [points[at] + sign * sx, points[at + 1] + sign * sy,
        points[at + 2] + lift];
    };
    const [a, b] = [corner(i, -1), corner(i, 1)];
    const [c, d] = [corner(i + 1, -1), corner(i + 1, 1)];
    out.set([...a, ...c, ...d, ...a, ...d, ...b], 18 * i);
  }
  return out;
}

export class PathLayer {
  private readonly corners = new Corners();
  readonly material = new MeshBasicMaterial({ side: DoubleSide });
  readonly object = new Mesh(this.corners.geometry, this.material);

  constructor() {
    this.object.frustumCulled = false;
  }

  set(path: Float32Array): void {
    const triangles = ribbon(path, 4, 0.07, 0.08);
    this.corners.take(triangles.length / 3).set(triangles);
  }
}
