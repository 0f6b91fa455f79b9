// Bubbles, goals, blockages, obstacles, and the arrow of a place that is being
// chosen.

import {
  BoxGeometry, BufferGeometry, CircleGeometry, DoubleSide, EdgesGeometry,
  Group, InstancedMesh, LineBasicMaterial, LineSegments, Matrix4, Mesh,
  MeshBasicMaterial, Object3D, RingGeometry, Shape, ShapeGeometry,
} from 'three';

import type { Pose, RobotScene } from '../../api/types.js';
import type { Theme } from '../theme.js';

const MOST_BUBBLES = 400;

export class BubbleLayer {
  readonly object = new Group();
  private readonly fill = new MeshBasicMaterial({
    transparent: true, opacity: 0.16, depthWrite: false, side: DoubleSide,
  });
  private readonly rim = new MeshBasicMaterial({
    transparent: true, opacity: 0.9, depthWrite: false, side: DoubleSide,
  });
  private readonly discs =
      new InstancedMesh(new CircleGeometry(1, 40), this.fill, MOST_BUBBLES);
  private readonly rings = new InstancedMesh(
      new RingGeometry(0.95, 1, 40), this.rim, MOST_BUBBLES);

  constructor() {
    for (const mesh of [this.discs, this.rings]) {
      mesh.frustumCulled = false;
      mesh.count = 0;
      this.object.add(mesh);
    }
  }

  paint(theme: Theme): void {
    this.fill.color.set(theme.bubble);
    this.rim.color.set(theme.bubble);
  }

  set(bubbles: Float32Array): void {
    const count = Math.min(MOST_BUBBLES, bubbles.length / 4);
    const matrix = new Matrix4();
    for (let i = 0; i < count; ++i) {
      const [x, y, z, radius] = bubbles.subarray(4 * i, 4 * i + 4);
      matrix.makeScale(radius, radius, 1);
      matrix.setPosition(x, y, z + 0.05);
      this.discs.setMatrixAt(i, matrix);
      this.rings.setMatrixAt(i, matrix);
    }
    for (const mesh of [this.discs, this.rings]) {
      mesh.count = count;
      mesh.instanceMatrix.needsUpdate = true;
    }
  }
}

function arrow(length: number): BufferGeometry {
  const shape = new Shape();
  shape.moveTo(0, -0.035);
  shape.lineTo(length - 0.2, -0.035);
  shape.lineTo(length - 0.2, -0.12);
  shape.lineTo(length, 0);
  shape.lineTo(length - 0.2, 0.12);
  shape.lineTo(length - 0.2, 0.035);
  shape.lineTo(0, 0.035);
  shape.closePath();
  return new ShapeGeometry(shape);
}

// A ring and an arrow on the ground: a pose.
export class PoseMark {
  readonly object = new Group();
  readonly material = new MeshBasicMaterial({
    side: DoubleSide, transparent: true, opacity: 0.95, depthTest: false,
  });

  constructor(length = 0.75) {
    const ring = new Mesh(new RingGeometry(0.24, 0.31, 40), this.material);
    const dot = new Mesh(new CircleGeometry(0.08, 24), this.material);
    this.object.add(ring, dot, new Mesh(arrow(length), this.material));
    this.object.renderOrder = 5;
    for (const child of this.object.children) child.renderOrder = 5;
    this.object.visible = false;
  }

  show(x: number, y: number, z: number, yaw: number): void {
    this.object.visible = true;
    this.object.position.set(x, y, z + 0.1);
    this.object.rotation.z = yaw;
  }

  hide(): void {
    this.object.visible = false;
  }
}

// As many as there are poses, of one colour and size.
export class PoseMarks {
  readonly object = new Group();
  private readonly marks: PoseMark[] = [];
  private colour = 0;

  constructor(private readonly scale = 1) {}

  paint(colour: number): void {
    this.colour = colour;
    for (const mark of this.marks) mark.material.color.set(colour);
  }

  set<P extends { x: number; y: number; yaw: number }>(
      poses: readonly P[], heightAt: (pose: P) => number): void {
    while (this.marks.length < poses.length) {
      const mark = new PoseMark();
      mark.material.color.set(this.colour);
      mark.object.scale.setScalar(this.scale);
      this.marks.push(mark);
      this.object.add(mark.object);
    }
    this.marks.forEach((mark, i) => {
      const pose = poses[i];
      if (pose === undefined) mark.hide();
      else mark.show(pose.x, pose.y, heightAt(pose), pose.yaw);
    });
  }
}

export class GoalLayer {
  private readonly marks = new PoseMarks();
  readonly object = this.marks.object;

  paint(theme: Theme): void {
    this.marks.paint(theme.goal);
  }

  set(poses: Pose[], heightAt: (pose: Pose) => number): void {
    this.marks.set(poses, heightAt);
  }
}

function removeAll(group: Object3D): void {
  for (const child of [...group.children]) group.remove(child);
}

export class BlockageLayer {
  readonly object = new Group();
  private readonly fill = new MeshBasicMaterial({
    transparent: true, opacity: 0.3, depthWrite: false, side: DoubleSide,
  });
  private readonly rim = new MeshBasicMaterial({ side: DoubleSide });
  private readonly disc = new CircleGeometry(1, 40);
  private readonly ring = new RingGeometry(0.9, 1, 40);

  paint(theme: Theme): void {
    this.fill.color.set(theme.blockage);
    this.rim.color.set(theme.blockage);
  }

  set(blockages: RobotScene['blockages'],
      heightAt: (x: number, y: number, level: number) => number): void {
    removeAll(this.object);
    for (const { x, y, radius, level } of blockages) {
      for (const mesh of [
        new Mesh(this.disc, this.fill), new Mesh(this.ring, this.rim),
      ]) {
        mesh.position.set(x, y, heightAt(x, y, level) + 0.06);
        mesh.scale.set(radius, radius, 1);
        this.object.add(mesh);
      }
    }
  }
}

const OBSTACLE_M = 0.5;

export class ObstacleLayer {
  readonly object = new Group();
  private readonly fill = new MeshBasicMaterial({
    transparent: true, opacity: 0.65,
  });
  private readonly line = new LineBasicMaterial();
  private readonly box = new BoxGeometry(OBSTACLE_M, OBSTACLE_M, OBSTACLE_M);
  private readonly edges = new EdgesGeometry(this.box);

  paint(theme: Theme): void {
    this.fill.color.set(theme.obstacle);
    this.line.color.set(theme.obstacle);
  }

  set(obstacles: RobotScene['obstacles'],
      heightAt: (x: number, y: number) => number): void {
    removeAll(this.object);
    for (const { x, y } of obstacles) {
      for (const part of [
        new Mesh(this.box, this.fill), new LineSegments(this.edges, this.line),
      ]) {
        part.position.set(x, y, heightAt(x, y) + OBSTACLE_M / 2 + 0.01);
        this.object.add(part);
      }
    }
  }
}
