// The robot's estimated pose, its uncertainty, and, in simulation, where
// it truly is.

import {
  BufferGeometry, DoubleSide, EdgesGeometry, ExtrudeGeometry, Float32BufferAttribute,
  Group, LineBasicMaterial, LineSegments, Mesh, MeshBasicMaterial, RingGeometry,
  Shape,
} from 'three';

import type { AgentInfo } from '../../api/types.js';
import type { Theme } from '../theme.js';

const HEIGHT_M = 0.32;

export interface Stand {
  x: number;
  y: number;
  z: number;
  yaw: number;
}

function arrowShape(front: number, rear: number, half: number): Shape {
  const shape = new Shape();
  shape.moveTo(front * 0.72, 0);
  shape.lineTo(-rear * 0.55, half * 0.6);
  shape.lineTo(-rear * 0.25, 0);
  shape.lineTo(-rear * 0.55, -half * 0.6);
  shape.closePath();
  return shape;
}

function bodyShape(robot: AgentInfo['robot']): Shape {
  const { front, rear, halfWidth } = robot;
  const cut = Math.min(front, halfWidth) * 0.3;
  const shape = new Shape();
  shape.moveTo(-rear, -halfWidth);
  shape.lineTo(front - cut, -halfWidth);
  shape.lineTo(front, -halfWidth + cut);
  shape.lineTo(front, halfWidth - cut);
  shape.lineTo(front - cut, halfWidth);
  shape.lineTo(-rear, halfWidth);
  shape.closePath();
  return shape;
}

function flat(shape: Shape, z: number, material: MeshBasicMaterial): Mesh {
  const geometry = new ExtrudeGeometry(shape, {
    depth: 0.004, bevelEnabled: false,
  });
  const mesh = new Mesh(geometry, material);
  mesh.position.z = z;
  return mesh;
}

export class RobotLayer {
  readonly robot = new Group();
  readonly truth = new Group();
  // Twice the standard deviation around the robot.
  readonly doubt: Mesh;
  private readonly bodyColour = new MeshBasicMaterial();
  private readonly edgeColour = new LineBasicMaterial();
  private readonly topColour = new MeshBasicMaterial();
  private readonly truthLines = new LineBasicMaterial();
  private readonly truthFill = new MeshBasicMaterial({
    transparent: true, opacity: 0.28, depthWrite: false,
  });
  private readonly uncertaintyColour = new MeshBasicMaterial({
    transparent: true, opacity: 0.35, side: DoubleSide, depthWrite: false,
  });

  constructor() {
    this.doubt = new Mesh(new RingGeometry(0.9, 1, 64), this.uncertaintyColour);
    this.robot.visible = this.truth.visible = this.doubt.visible = false;
  }

  build(robot: AgentInfo['robot']): void {
    for (const group of [this.robot, this.truth]) {
      for (const child of [...group.children]) {
        group.remove(child);
        if (child instanceof Mesh || child instanceof LineSegments) {
          (child.geometry as BufferGeometry).dispose();
        }
      }
    }
    const shape = bodyShape(robot);
    const prism = new ExtrudeGeometry(
        shape, { depth: HEIGHT_M - 0.05, bevelEnabled: false });
    prism.translate(0, 0, 0.05);
    this.robot.add(
        new Mesh(prism, this.bodyColour),
        new LineSegments(new EdgesGeometry(prism, 20), this.edgeColour),
        flat(arrowShape(robot.front, robot.rear, robot.halfWidth),
            HEIGHT_M + 0.002, this.topColour));
    this.truth.add(
        flat(shape, 0.03, this.truthFill),
        new LineSegments(new EdgesGeometry(prism, 20), this.truthLines),
        this.nose(robot));
  }

  private nose(robot: AgentInfo['robot']): LineSegments {
    const geometry = new BufferGeometry();
    const { front } = robot;
    geometry.setAttribute('position', new Float32BufferAttribute([
      0, 0, HEIGHT_M, front + 0.25, 0, HEIGHT_M,
      front + 0.25, 0, HEIGHT_M, front + 0.12, 0.08, HEIGHT_M,
      front + 0.25, 0, HEIGHT_M, front + 0.12, -0.08, HEIGHT_M,
    ], 3));
    return new LineSegments(geometry, this.truthLines);
  }

  paint(theme: Theme): void {
    this.bodyColour.color.set(theme.robot);
    this.topColour.color.set(theme.robotTop);
    this.edgeColour.color.set(theme.robotTop);
    this.truthLines.color.set(theme.truth);
    this.truthFill.color.set(theme.truth);
    this.uncertaintyColour.color.set(theme.robot);
  }

  place(group: Group, at: Stand | null): void {
    group.visible = at !== null;
    if (at === null) return;
    group.position.set(at.x, at.y, at.z);
    group.rotation.z = at.yaw;
  }

  placeDoubt(at: Stand | null, std: number | null): void {
    const radius = std === null ? 0 : 2 * std;
    this.doubt.visible = at !== null && radius > 0.02;
    if (at === null) return;
    this.doubt.position.set(at.x, at.y, at.z + 0.03);
    this.doubt.scale.setScalar(Math.max(radius, 0.02));
  }
}
