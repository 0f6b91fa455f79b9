// A scene in three dimensions: its points, the path of its keyframes, where
// queries will be answered, and where the latest were located.

import { toColumnMajor4, transformPoint, type Pinhole, type RecentQuery,
  type SceneMap, type Vector3 } from '@treeline/client';
import * as THREE from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { LineMaterial } from 'three/addons/lines/LineMaterial.js';
import { LineSegments2 } from 'three/addons/lines/LineSegments2.js';
import { LineSegmentsGeometry } from
  'three/addons/lines/LineSegmentsGeometry.js';

import { ballOf, coveragePixels, pinholeOf, pointColors, pyramid, type Ball }
  from '../model/scene_picture.js';
import { el } from '../common/dom.js';

export type SceneLayer = 'points' | 'path' | 'coverage' | 'queries';
export type Viewpoint = 'overview' | 'above' | 'side';

const FIELD_OF_VIEW_DEG = 50;
// Of the scene's size.
const PYRAMID_SHARE = 0.018;
const POINT_SHARE = 0.0035;
// For one press of a key.
const TURN_RAD = Math.PI / 24;
const ZOOM = 0.85;
const LINE_PX = 1.5;
const CHOSEN_PX = 3;

interface Theme {
  readonly isDark: boolean;
  readonly path: number;
  readonly query: number;
  readonly chosen: number;
}

const LIGHT: Theme = { isDark: false, path: 0x1f5fd0, query: 0x17624a,
  chosen: 0xb3261e };
const DARK: Theme = { isDark: true, path: 0x8ab4ff, query: 0x4fc796,
  chosen: 0xff8f86 };

// From where, in the plan, times the distance.
const DIRECTIONS: Readonly<Record<Viewpoint, Vector3>> = {
  overview: { x: 0.55, y: -0.65, z: 0.6 },
  // Not quite: the heading would be none.
  above: { x: 0, y: -1e-3, z: 1 },
  side: { x: 0, y: -1, z: 0.06 },
};

const endsOf = (points: readonly Vector3[]): number[] =>
  points.flatMap(({ x, y, z }) => [x, y, z]);

function linesOf(ends: readonly number[], color: number, linewidth: number):
    LineSegments2 {
  return new LineSegments2(
      new LineSegmentsGeometry().setPositions([...ends]),
      new LineMaterial({ color, linewidth }));
}

function dispose(group: THREE.Object3D): void {
  group.traverse((part) => {
    const { geometry, material } = part as THREE.Mesh;
    geometry?.dispose();
    for (const each of [material ?? []].flat()) {
      (each as THREE.MeshBasicMaterial).map?.dispose();
      each.dispose();
    }
  });
  group.clear();
}

export class SceneView {
  readonly element: HTMLElement;
  private readonly canvas: HTMLCanvasElement;
  private readonly renderer: THREE.WebGLRenderer;
  private readonly scene = new THREE.Scene();
  // Of the world, turned into the plan; coverage is in the plan already.
  private readonly world = new THREE.Group();
  private readonly layers: Readonly<Record<SceneLayer, THREE.Group>> = {
    points: new THREE.Group(), path: new THREE.Group(),
    coverage: new THREE.Group(), queries: new THREE.Group(),
  };
  private readonly camera =
      new THREE.PerspectiveCamera(FIELD_OF_VIEW_DEG, 1, 0.05, 1000);
  private readonly controls: OrbitControls;
  private readonly darkness =
      window.matchMedia('(prefers-color-scheme: dark)');
  private map: SceneMap | null = null;
  private pinhole: Pinhole | null = null;
  private ball: Ball = { centreM: { x: 0, y: 0, z: 0 }, radiusM: 5 };
  private queries: readonly RecentQuery[] = [];
  private chosen = -1;
  private isDrawn = true;

  constructor() {
    this.renderer = new THREE.WebGLRenderer({ alpha: true, antialias: true });
    this.canvas = this.renderer.domElement;
    this.canvas.className = 'scene-canvas';
    this.canvas.setAttribute('aria-hidden', 'true');
    this.element = el('div', { class: 'scene-view', id: 'view3d', attributes: {
      'tabindex': '0', 'role': 'application', 'aria-label': 'Scene. The arrow ' +
        'keys turn it, plus and minus zoom, Shift and arrows move it, Home ' +
        'shows all of it.', 'aria-describedby': 'description' },
    on: { keydown: (event) => this.onKey(event) } }, this.canvas);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.enableDamping = false;
    this.controls.addEventListener('change', () => this.draw());
    this.world.add(this.layers.points, this.layers.path, this.layers.queries);
    this.scene.add(this.layers.coverage, this.world);
    new ResizeObserver(() => this.resize()).observe(this.element);
    this.darkness.addEventListener('change', () => this.build());
  }

  /** Null: there is nothing to show. */
  setMap(map: SceneMap | null): void {
    this.map = map;
    this.pinhole = map?.camera ? pinholeOf(map.camera) : null;
    this.chosen = -1;
    this.queries = [];
    if (map !== null) {
      const { x, y, z, w } = map.planFromWorld;
      this.world.quaternion.set(x, y, z, w);
      this.ball = ballOf(map);
    }
    this.build();
    this.look('overview');
  }

  setQueries(queries: readonly RecentQuery[], chosen: number): void {
    this.queries = queries;
    this.chosen = chosen;
    this.buildQueries();
    this.draw();
  }

  show(layer: SceneLayer, isShown: boolean): void {
    this.layers[layer].visible = isShown;
    this.draw();
  }

  look(from: Viewpoint): void {
    const { centreM, radiusM } = this.ball;
    // The whole ball is in the narrower field of view.
    const half = THREE.MathUtils.degToRad(FIELD_OF_VIEW_DEG) / 2;
    const narrow = Math.min(half,
        Math.atan(Math.tan(half) * this.camera.aspect));
    const distanceM = radiusM / Math.sin(narrow);
    const direction = DIRECTIONS[from];
    this.camera.near = radiusM / 100;
    this.camera.far = 100 * radiusM;
    this.camera.updateProjectionMatrix();
    this.controls.target.copy(centreM);
    this.camera.position.copy(direction).normalize()
        .multiplyScalar(distanceM).add(this.controls.target);
    this.controls.update();
    this.draw();
  }

  /** Less than 1: nearer. */
  zoom(factor: number): void {
    this.camera.position.sub(this.controls.target).multiplyScalar(factor)
        .add(this.controls.target);
    this.controls.update();
    this.draw();
  }

  /** Where a point of the world is drawn, as a share of the view. */
  shareOf(x: number, y: number, z: number): { x: number; y: number } | null {
    this.scene.updateMatrixWorld();
    this.camera.updateMatrixWorld();
    const point = new THREE.Vector3(x, y, z)
        .applyMatrix4(this.world.matrixWorld).project(this.camera);
    if (point.z > 1 || point.z < -1) return null;
    return { x: (point.x + 1) / 2, y: (1 - point.y) / 2 };
  }

  private get theme(): Theme {
    return this.darkness.matches ? DARK : LIGHT;
  }

  private get pyramidM(): number {
    return Math.max(0.05, 2 * this.ball.radiusM * PYRAMID_SHARE);
  }

  private build(): void {
    for (const group of Object.values(this.layers)) dispose(group);
    if (this.map !== null) {
      this.buildPoints(this.map);
      this.buildPath(this.map);
      this.buildCoverage(this.map);
      this.buildQueries();
    }
    this.draw();
  }

  private buildPoints({ pointsInWorldM, brightness }: SceneMap): void {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position',
        new THREE.BufferAttribute(pointsInWorldM, 3));
    geometry.setAttribute('color', new THREE.BufferAttribute(
        pointColors(brightness, this.theme.isDark), 3));
    this.layers.points.add(new THREE.Points(geometry, new THREE.PointsMaterial({
      size: 2 * this.ball.radiusM * POINT_SHARE, vertexColors: true })));
  }

  private buildPath({ worldFromKeyframe }: SceneMap): void {
    const places = worldFromKeyframe.map(({ translationM }) => translationM);
    const ends = places.slice(1).flatMap((place, i) => [places[i]!, place]);
    for (const pose of worldFromKeyframe) ends.push(...this.pyramidOf(pose));
    if (ends.length > 0) {
      this.layers.path.add(linesOf(endsOf(ends), this.theme.path, LINE_PX));
    }
  }

  private pyramidOf(pose: SceneMap['worldFromKeyframe'][number]): Vector3[] {
    return this.pinhole === null ? [] :
      pyramid(this.pinhole, this.pyramidM)
          .map((point) => transformPoint(pose, point));
  }

  private buildCoverage({ coverage }: SceneMap): void {
    if (coverage === null || coverage.columns * coverage.rows === 0) return;
    const { columns, rows, cellM, minXM, minYM, groundM } = coverage;
    const texture = new THREE.DataTexture(coveragePixels(coverage), columns,
        rows);
    texture.colorSpace = THREE.SRGBColorSpace;
    texture.magFilter = THREE.NearestFilter;
    texture.needsUpdate = true;
    const plane = new THREE.Mesh(
        new THREE.PlaneGeometry(columns * cellM, rows * cellM),
        new THREE.MeshBasicMaterial({ map: texture, transparent: true,
          side: THREE.DoubleSide, depthWrite: false }));
    plane.position.set(minXM + columns * cellM / 2, minYM + rows * cellM / 2,
        groundM);
    this.layers.coverage.add(plane);
  }

  private buildQueries(): void {
    dispose(this.layers.queries);
    const { query, chosen } = this.theme;
    const others: Vector3[] = [];
    const radiusM = 0.3 * this.pyramidM;
    this.queries.forEach(({ worldFromCamera }, i) => {
      if (worldFromCamera === null) return;
      const isChosen = i === this.chosen;
      const ball = new THREE.Mesh(
          new THREE.SphereGeometry(isChosen ? 2 * radiusM : radiusM, 12, 8),
          new THREE.MeshBasicMaterial({ color: isChosen ? chosen : query }));
      ball.matrixAutoUpdate = false;
      ball.matrix.fromArray(toColumnMajor4(worldFromCamera));
      this.layers.queries.add(ball);
      const lines = this.pyramidOf(worldFromCamera);
      if (lines.length === 0) return;
      if (isChosen) {
        this.layers.queries.add(linesOf(endsOf(lines), chosen, CHOSEN_PX));
      } else {
        others.push(...lines);
      }
    });
    if (others.length > 0) {
      this.layers.queries.add(linesOf(endsOf(others), query, LINE_PX));
    }
  }

  private onKey(event: KeyboardEvent): void {
    const { key, shiftKey, ctrlKey, altKey, metaKey } = event;
    if (ctrlKey || altKey || metaKey) return;
    if (key === 'Home') this.look('overview');
    else if (key === '+' || key === '=') this.zoom(ZOOM);
    else if (key === '-') this.zoom(1 / ZOOM);
    else if (key.startsWith('Arrow')) {
      const x = key === 'ArrowLeft' ? -1 : key === 'ArrowRight' ? 1 : 0;
      const y = key === 'ArrowUp' ? 1 : key === 'ArrowDown' ? -1 : 0;
      if (shiftKey) this.move(x, y);
      else this.turn(x, y);
    } else return;
    event.preventDefault();
  }

  private turn(x: number, y: number): void {
    const offset = this.camera.position.clone().sub(this.controls.target);
    const place = new THREE.Spherical().setFromVector3(
        new THREE.Vector3(offset.x, offset.z, -offset.y));
    place.theta += x * TURN_RAD;
    place.phi -= y * TURN_RAD;
    place.makeSafe();
    const turned = new THREE.Vector3().setFromSpherical(place);
    this.camera.position.set(turned.x, -turned.z, turned.y)
        .add(this.controls.target);
    this.controls.update();
    this.draw();
  }

  private move(x: number, y: number): void {
    const step = new THREE.Vector3(x, y, 0)
        .multiplyScalar(0.1 * this.ball.radiusM)
        .applyQuaternion(this.camera.quaternion);
    this.camera.position.add(step);
    this.controls.target.add(step);
    this.controls.update();
    this.draw();
  }

  private resize(): void {
    const { clientWidth, clientHeight } = this.element;
    if (clientWidth === 0 || clientHeight === 0) return;
    const before = this.camera.aspect;
    this.camera.aspect = clientWidth / clientHeight;
    this.camera.updateProjectionMatrix();
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio));
    this.renderer.setSize(clientWidth, clientHeight, false);
    // A phone that was turned shows all of it again.
    if ((before < 1) !== (this.camera.aspect < 1)) this.look('overview');
    this.draw();
  }

  // Once a frame of the screen at most: nothing moves by itself.
  private draw(): void {
    if (!this.isDrawn) return;
    this.isDrawn = false;
    requestAnimationFrame(() => {
      this.isDrawn = true;
      this.renderer.render(this.scene, this.camera);
    });
  }
}
