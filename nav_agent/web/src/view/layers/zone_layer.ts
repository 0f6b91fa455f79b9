// Zones on the ground: what is drawn, what masks say, and what is being drawn.

import {
  BufferGeometry, DoubleSide, Float32BufferAttribute, Group, Line,
  LineBasicMaterial, LineLoop, Mesh, MeshBasicMaterial, Points, PointsMaterial,
  Shape, ShapeUtils, Vector2, type Object3D,
} from 'three';

import type { LevelInfo, ZoneKind, Zones } from '../../api/types.js';
import type { Place } from '../../model/gesture.js';
import type { Theme } from '../theme.js';

type HeightAt = (x: number, y: number) => number;

// Above the ground, so that it is not hidden by it (m).
const RAISED_M = 0.06;
const ARROW_M = 0.5;

interface Paints {
  fill: MeshBasicMaterial;
  line: LineBasicMaterial;
}

function paints(): Paints {
  return {
    fill: new MeshBasicMaterial({
      transparent: true, opacity: 0.28, depthWrite: false, side: DoubleSide }),
    line: new LineBasicMaterial({ transparent: true, depthTest: false }),
  };
}

function positions(points: readonly (readonly number[])[]): BufferGeometry {
  const geometry = new BufferGeometry();
  geometry.setAttribute(
      'position', new Float32BufferAttribute(points.flat(), 3));
  return geometry;
}

export class ZoneLayer {
  readonly object = new Group();
  private readonly zones = new Group();
  private readonly draft = new Group();
  private readonly kinds: Record<ZoneKind, Paints> = {
    'keep-out': paints(), 'speed': paints(), 'one-way': paints(),
  };
  private readonly corner = new PointsMaterial({
    size: 12, sizeAttenuation: false, depthTest: false, transparent: true });

  constructor() {
    this.object.add(this.zones, this.draft);
    this.object.renderOrder = 2;
  }

  paint(theme: Theme): void {
    for (const [kind, { fill, line }] of Object.entries(this.kinds)) {
      fill.color.set(theme.zones[kind as ZoneKind]);
      line.color.set(theme.zones[kind as ZoneKind]);
    }
    this.corner.color.set(theme.goal);
  }

  set(zones: Zones, level: LevelInfo | null, heightAt: HeightAt): void {
    this.clear(this.zones);
    for (const zone of zones.zones) {
      if (zone.level !== level?.index) continue;
      this.addArea(zone.corners, zone.kind, heightAt);
      if (zone.kind === 'one-way') {
        this.addArrow(zone.corners, zone.direction, heightAt);
      }
    }
    for (const mask of zones.masks) {
      if (level === null || mask.level !== level.index) continue;
      this.addRuns(mask.runs, mask.kind, level, heightAt);
    }
  }

  setDraft(corners: readonly Place[], kind: ZoneKind, heightAt: HeightAt):
      void {
    this.clear(this.draft);
    if (corners.length === 0) return;
    const points = positions(corners.map(
        ({ x, y }) => [x, y, heightAt(x, y) + RAISED_M]));
    const { line } = this.kinds[kind];
    this.put(this.draft, new Points(points, this.corner));
    this.put(this.draft, corners.length > 2 ?
      new LineLoop(points, line) : new Line(points, line));
  }

  private put(group: Group, object: Object3D): void {
    object.renderOrder = 2;
    object.frustumCulled = false;
    group.add(object);
  }

  private clear(group: Group): void {
    for (const child of [...group.children]) {
      (child as Mesh).geometry.dispose();
      group.remove(child);
    }
  }

  private addArea(corners: readonly Place[], kind: ZoneKind,
      heightAt: HeightAt): void {
    const points = corners.map(
        ({ x, y }) => [x, y, heightAt(x, y) + RAISED_M]);
    const outline = new Shape(corners.map(({ x, y }) => new Vector2(x, y)));
    const area = positions(points);
    area.setIndex(
        ShapeUtils.triangulateShape(outline.getPoints(), []).flat());
    this.put(this.zones, new Mesh(area, this.kinds[kind].fill));
    this.put(this.zones, new LineLoop(positions(points), this.kinds[kind].line));
  }

  // In the middle of its corners.
  private addArrow(corners: readonly Place[], direction: number,
      heightAt: HeightAt): void {
    const middle = (of: (corner: Place) => number): number =>
      corners.reduce((sum, corner) => sum + of(corner), 0) / corners.length;
    const [x, y] = [middle((corner) => corner.x), middle((corner) => corner.y)];
    const z = heightAt(x, y) + RAISED_M;
    const at = (ahead: number, left: number): number[] => [
      x + ahead * Math.cos(direction) - left * Math.sin(direction),
      y + ahead * Math.sin(direction) + left * Math.cos(direction), z];
    const [tip, back] = [ARROW_M, ARROW_M / 2];
    this.put(this.zones, new Line(positions([
      at(-tip, 0), at(tip, 0), at(back, back), at(tip, 0), at(back, -back),
    ]), this.kinds['one-way'].line));
  }

  private addRuns(runs: readonly number[], kind: ZoneKind, level: LevelInfo,
      heightAt: HeightAt): void {
    const [x0, y0, yaw] = level.origin;
    const corner = (column: number, row: number): number[] => {
      const [a, b] = [column * level.resolution, row * level.resolution];
      const x = x0 + a * Math.cos(yaw) - b * Math.sin(yaw);
      const y = y0 + a * Math.sin(yaw) + b * Math.cos(yaw);
      return [x, y, heightAt(x, y) + RAISED_M];
    };
    const triangles: number[][] = [];
    for (let i = 0; i + 2 < runs.length; i += 3) {
      const [row, begin, end] = runs.slice(i, i + 3);
      const [a, b] = [corner(begin, row), corner(end, row)];
      const [c, d] = [corner(end, row + 1), corner(begin, row + 1)];
      triangles.push(a, b, c, a, c, d);
    }
    if (triangles.length === 0) return;
    this.put(this.zones,
        new Mesh(positions(triangles), this.kinds[kind].fill));
  }
}
