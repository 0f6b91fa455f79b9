// What is drawn over the video, in the world of the scene: its grid, its box
// and the notes' places.

import { IDENTITY, inverse, toColumnMajor4, toOpenGlCamera, transformPoint, type Pinhole,
  type RigidTransform, type SceneMap } from '@treeline/client';
import * as THREE from 'three';
import { LineMaterial } from 'three/addons/lines/LineMaterial.js';
import { LineSegments2 } from 'three/addons/lines/LineSegments2.js';
import { LineSegmentsGeometry } from
  'three/addons/lines/LineSegmentsGeometry.js';

import type { Note } from '../model/notes.js';
import { pinholeOf, pyramid } from '../model/scene_picture.js';
import type { LocatedPicture } from '../model/pin.js';
import { axisOf, floorM, type Bounds, type UpAxis } from
  '../model/scene_up.js';

// Seen on light and on dark pictures alike, in either theme.
const GRID = 0x7cf0bd;
const BOX = 0xffc857;
const NOTE = 0xff7a59;
const CLOUD = 0x8fe3ff;
const KEYFRAMES = 0xe8a2ff;
// Of the screen, whatever its density.
const LINE_PX = 2;
const NEAR_M = 0.05;
const FAR_M = 200;
const NOTE_RADIUS_M = 0.03;
const CLOUD_PX = 2;
const KEYFRAME_DEPTH_M = 0.12;

// Of OpenGL, column-major: x right, y up, z backwards, depth to [-1, 1].
// Pixel centres are whole numbers, so that a picture begins at -0.5.
function projectionOf(
    { widthPx, heightPx, fxPx, fyPx, cxPx, cyPx }: Pinhole): THREE.Matrix4 {
  const depth = FAR_M - NEAR_M;
  return new THREE.Matrix4().set(
      2 * fxPx / widthPx, 0, 1 - 2 * (cxPx + 0.5) / widthPx, 0,
      0, 2 * fyPx / heightPx, 2 * (cyPx + 0.5) / heightPx - 1, 0,
      0, 0, -(FAR_M + NEAR_M) / depth, -2 * FAR_M * NEAR_M / depth,
      0, 0, -1, 0);
}

function setPose(object: THREE.Object3D, worldFrom: RigidTransform): void {
  object.matrixAutoUpdate = false;
  object.matrix.fromArray(toColumnMajor4(worldFrom));
  object.matrixWorldNeedsUpdate = true;
}

// `ends`: x, y, z of both ends of each line.
function linesOf(ends: readonly number[], color: number): LineSegments2 {
  return new LineSegments2(
      new LineSegmentsGeometry().setPositions([...ends]),
      new LineMaterial({ color, linewidth: LINE_PX }));
}

// Whole metres of the world, on the floor within the box.
function gridOf(bounds: Bounds, up: UpAxis): LineSegments2 {
  const { min, max } = bounds;
  const [a, b] = (['x', 'y', 'z'] as const).filter(
      (axis) => axis !== axisOf(up)) as ['x' | 'y' | 'z', 'x' | 'y' | 'z'];
  const ends: number[] = [];
  for (const [across, along] of [[a, b], [b, a]] as const) {
    for (let at = Math.ceil(min[across]); at <= max[across]; ++at) {
      for (const end of [min[along], max[along]]) {
        const point = new THREE.Vector3();
        point[across] = at;
        point[along] = end;
        point[axisOf(up)] = floorM(bounds, up);
        ends.push(...point);
      }
    }
  }
  return linesOf(ends, GRID);
}

function boxOf({ min, max }: Bounds): LineSegments2 {
  const size = new THREE.Vector3().subVectors(
      new THREE.Vector3().copy(max), new THREE.Vector3().copy(min));
  const edges = new THREE.EdgesGeometry(
      new THREE.BoxGeometry(...size).translate(
          (min.x + max.x) / 2, (min.y + max.y) / 2, (min.z + max.z) / 2));
  return linesOf([...edges.getAttribute('position').array], BOX);
}

export type OverlayLayer = 'grid' | 'box' | 'cloud' | 'keyframes';

function cloudOf({ pointsInWorldM }: SceneMap): THREE.Points {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position',
      new THREE.BufferAttribute(pointsInWorldM, 3));
  return new THREE.Points(geometry, new THREE.PointsMaterial(
      { color: CLOUD, size: CLOUD_PX * Math.min(2, window.devicePixelRatio),
        sizeAttenuation: false }));
}

function keyframesOf({ camera, worldFromKeyframe }: SceneMap): LineSegments2 {
  const corners = camera === null ? [] :
    pyramid(pinholeOf(camera), KEYFRAME_DEPTH_M);
  return linesOf(worldFromKeyframe.flatMap((pose) =>
    corners.flatMap((corner) => {
      const { x, y, z } = transformPoint(pose, corner);
      return [x, y, z];
    })), KEYFRAMES);
}

export class Overlay {
  readonly canvas: HTMLCanvasElement;
  readonly renderer: THREE.WebGLRenderer;
  private readonly scene = new THREE.Scene();
  private readonly camera = new THREE.Camera();
  // The device's own, while a session in the space around it is presented.
  private readonly spaceCamera =
      new THREE.PerspectiveCamera(60, 1, NEAR_M, FAR_M);
  private readonly notes = new THREE.Group();
  private readonly drawings = new Map<OverlayLayer,
      LineSegments2 | THREE.Points>();
  private readonly hidden = new Set<OverlayLayer>(['cloud', 'keyframes']);
  private picture: LocatedPicture | null = null;

  constructor() {
    this.renderer = new THREE.WebGLRenderer({ alpha: true, antialias: true });
    this.canvas = this.renderer.domElement;
    this.canvas.className = 'overlay';
    this.canvas.setAttribute('aria-hidden', 'true');
    this.scene.add(this.notes);
  }

  setScene(bounds: Bounds | null, up: UpAxis): void {
    this.replace('grid', bounds === null ? null : gridOf(bounds, up));
    this.replace('box', bounds === null ? null : boxOf(bounds));
    this.draw();
  }

  /** What the scene's model knows; null: nothing. */
  setMap(map: SceneMap | null): void {
    this.replace('cloud', map === null ? null : cloudOf(map));
    this.replace('keyframes', map === null ? null : keyframesOf(map));
    this.draw();
  }

  setNotes(notes: readonly Note[]): void {
    for (const child of this.notes.children as THREE.Mesh[]) {
      child.geometry.dispose();
      (child.material as THREE.Material).dispose();
    }
    this.notes.clear();
    for (const { pointInWorldM } of notes) {
      const mark = new THREE.Mesh(new THREE.SphereGeometry(NOTE_RADIUS_M),
          new THREE.MeshBasicMaterial({ color: NOTE }));
      mark.position.copy(pointInWorldM);
      this.notes.add(mark);
    }
    this.draw();
  }

  show(layer: OverlayLayer, isShown: boolean): void {
    if (isShown) this.hidden.delete(layer);
    else this.hidden.add(layer);
    this.draw();
  }

  /** Null: nothing is known of where the camera is. */
  setPicture(picture: LocatedPicture | null): void {
    this.picture = picture;
    if (picture !== null) {
      setPose(this.camera, toOpenGlCamera(picture.worldFromCamera));
      this.camera.projectionMatrix = projectionOf(picture.camera);
      this.camera.projectionMatrixInverse =
          this.camera.projectionMatrix.clone().invert();
    }
    this.draw();
  }

  /** From now on drawSpace() draws, in the session's frames. */
  async present(session: XRSession): Promise<void> {
    this.picture = null;
    this.renderer.xr.enabled = true;
    this.renderer.xr.setReferenceSpaceType('local');
    await this.renderer.xr.setSession(session);
  }

  /** The session has ended. */
  leaveSpace(): void {
    this.renderer.setAnimationLoop(null);
    this.renderer.xr.enabled = false;
    setPose(this.scene, IDENTITY);
    this.scene.visible = true;
  }

  /** Null: nothing is known of where the device's space is in the world. */
  drawSpace(worldFromDevice: RigidTransform | null): void {
    this.scene.visible = worldFromDevice !== null;
    if (worldFromDevice !== null) setPose(this.scene, inverse(worldFromDevice));
    this.renderer.render(this.scene, this.spaceCamera);
  }

  resize(widthPx: number, heightPx: number): void {
    if (this.renderer.xr.isPresenting) return;
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio));
    this.renderer.setSize(widthPx, heightPx, false);
    this.draw();
  }

  /** Where three.js draws a point of the world, as a share of the picture. */
  shareOf(x: number, y: number, z: number): { x: number; y: number } | null {
    const inSpace = this.renderer.xr.isPresenting;
    if (inSpace ? !this.scene.visible : this.picture === null) return null;
    this.camera.updateMatrixWorld();
    const point = new THREE.Vector3(x, y, z).applyMatrix4(this.scene.matrix)
        .project(inSpace ? this.spaceCamera : this.camera);
    if (point.z > 1 || point.z < -1) return null;
    return { x: (point.x + 1) / 2, y: (1 - point.y) / 2 };
  }

  private replace(layer: OverlayLayer,
      drawing: LineSegments2 | THREE.Points | null): void {
    const before = this.drawings.get(layer);
    if (before !== undefined) {
      this.scene.remove(before);
      before.geometry.dispose();
      (before.material as THREE.Material).dispose();
      this.drawings.delete(layer);
    }
    if (drawing === null) return;
    this.drawings.set(layer, drawing);
    this.scene.add(drawing);
  }

  private draw(): void {
    for (const [layer, drawing] of this.drawings) {
      drawing.visible = !this.hidden.has(layer);
    }
    // The session's next frame draws.
    if (this.renderer.xr.isPresenting) return;
    if (this.picture === null) this.renderer.clear();
    else this.renderer.render(this.scene, this.camera);
  }
}
