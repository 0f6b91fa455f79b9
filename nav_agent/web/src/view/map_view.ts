// The building in 3D: camera, layers, and when to draw.

import {
  Box3, Color, ColorManagement, LinearSRGBColorSpace, MOUSE, PerspectiveCamera,
  Raycaster, Scene, TOUCH, Vector2, Vector3, WebGLRenderer,
} from 'three';
import { MapControls } from 'three/examples/jsm/controls/MapControls.js';

import type {
  Dock, AgentInfo, RobotScene, RobotState, Route, Waypoint, ZoneKind, Zones,
} from '../api/types.js';
import { turnBetween, type Place } from '../model/gesture.js';
import type { HeightField } from '../model/height_field.js';
import { cutHeight, DEFAULT_CUT_M } from '../model/levels.js';
import { restAfter } from '../model/pace.js';
import { isUnderWay } from '../model/words.js';
import type { VoxelMesh } from '../model/voxel_mesh.js';
import { frameBox } from './framing.js';
import { CostmapLayer, isAround } from './layers/costmap_layer.js';
import { GroundLayer } from './layers/ground_layer.js';
import {
  ParticleLayer, PathLayer, ScanLayer, TreeLayer,
} from './layers/line_layers.js';
import {
  BlockageLayer, BubbleLayer, GoalLayer, ObstacleLayer, PoseMark,
} from './layers/mark_layers.js';
import { OtherPlacesLayer } from './layers/other_places_layer.js';
import { RobotLayer, type Stand } from './layers/robot_layer.js';
import { DockLayer } from './layers/dock_layer.js';
import { RouteLayer } from './layers/route_layer.js';
import { VoxelLayer } from './layers/voxel_layer.js';
import { ZoneLayer } from './layers/zone_layer.js';
import { currentTheme, onThemeChange } from './theme.js';

export const LAYERS = [
  'octomap', 'ground', 'zones', 'costmap', 'scan', 'particles', 'tree',
  'route', 'docks', 'path', 'bubbles', 'blockages', 'truth',
] as const;
export type LayerName = typeof LAYERS[number];

export type Angle = 'oblique' | 'top';

// Colours are shown as they are written: nothing is lit here.
ColorManagement.enabled = false;

// The robot glides to its newest pose in about this time (ms).
const GLIDE_MS = 120;
// A followed robot is looked at from not farther than this (m).
const FOLLOW_FROM_M = 9;
// How the view in 3D leans from the vertical.
const TILT_RAD = 0.52;
// What tools take of the picture's height, above and below (pixels).
const TOP_BAR_PX = 56;
const BOTTOM_BAR_PX = 68;

// Whether a graphics card draws, not the processor.
function isDrawnFast(): boolean {
  const context = document.createElement('canvas').getContext(
      'webgl2', { failIfMajorPerformanceCaveat: true });
  const names = context?.getExtension('WEBGL_debug_renderer_info');
  if (!context || !names) return context !== null;
  const name = String(context.getParameter(names.UNMASKED_RENDERER_WEBGL));
  return !/swiftshader|llvmpipe|software/i.test(name);
}

export class MapView {
  readonly canvas: HTMLCanvasElement;
  readonly controls: MapControls;
  readonly choice = new PoseMark();
  private readonly renderer: WebGLRenderer;
  private readonly scene = new Scene();
  private readonly camera = new PerspectiveCamera(45, 1, 0.3, 200);
  private theme = currentTheme();
  private readonly voxels = new VoxelLayer();
  private readonly ground = new GroundLayer();
  private readonly robot = new RobotLayer();
  private readonly otherPlaces = new OtherPlacesLayer();
  private readonly costmap = new CostmapLayer();
  private readonly scan = new ScanLayer();
  private readonly particles = new ParticleLayer();
  private readonly tree = new TreeLayer();
  private readonly path = new PathLayer();
  private readonly bubbles = new BubbleLayer();
  private readonly goal = new GoalLayer();
  private readonly blockages = new BlockageLayer();
  private readonly obstacles = new ObstacleLayer();
  private readonly zones = new ZoneLayer();
  private readonly routes = new RouteLayer();
  private readonly docks = new DockLayer();
  private shownZones: Zones | null = null;
  private fields: HeightField[] = [];
  private level = 0;
  private cutAboveGround = DEFAULT_CUT_M;
  private hidden = new Set<LayerName>();
  private hasCostmap = false;
  private state: RobotState | null = null;
  private shown: Stand | null = null;
  private wanted: Stand | null = null;
  private isDue = false;
  private lastFrame = 0;
  // Not to draw before (ms).
  private restsUntil = 0;
  private followsRobot = false;
  // Called with each picture: how many pixels a metre has where one looks at.
  onScale: ((pixelsPerMetre: number) => void) | null = null;

  // Throws if the browser has no WebGL.
  constructor(private readonly host: HTMLElement) {
    this.renderer = new WebGLRenderer(
        { antialias: isDrawnFast(), powerPreference: 'low-power' });
    this.renderer.outputColorSpace = LinearSRGBColorSpace;
    this.renderer.localClippingEnabled = true;
    this.canvas = this.renderer.domElement;
    this.canvas.className = 'map-canvas';
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute('role', 'application');
    this.canvas.setAttribute('aria-label',
        'Map in 3D. Arrow keys move it, plus and minus zoom; with a tool ' +
        'chosen, Enter places in the middle.');
    host.prepend(this.canvas);
    this.camera.up.set(0, 0, 1);
    this.controls = new MapControls(this.camera, this.canvas);
    this.controls.enableDamping = false;
    this.controls.zoomToCursor = true;
    this.controls.minDistance = 1;
    this.controls.maxDistance = 90;
    this.controls.maxPolarAngle = 0.47 * Math.PI;
    this.controls.listenToKeyEvents(this.canvas);
    this.canvas.addEventListener('keydown', (event) => this.zoomBy(event.key));
    this.controls.addEventListener('change', () => this.draw());
    this.scene.add(
        this.voxels.object, this.ground.object, this.zones.object,
        this.costmap.object,
        this.tree.object, this.bubbles.object, this.path.object,
        this.blockages.object, this.obstacles.object, this.particles.object,
        this.scan.object, this.robot.doubt, this.robot.truth, this.robot.robot,
        this.otherPlaces.object, this.routes.object, this.docks.object,
        this.goal.object,
        this.choice.object);
    this.paint();
    onThemeChange(() => {
      this.theme = currentTheme();
      this.paint();
    });
    new ResizeObserver(() => this.resize()).observe(host);
    this.resize();
  }

  private paint(): void {
    const { theme } = this;
    this.scene.background = new Color(theme.background);
    this.scan.material.color.set(theme.scan);
    this.particles.material.color.set(theme.particle);
    this.tree.material.color.set(theme.tree);
    this.path.material.color.set(theme.path);
    this.choice.material.color.set(theme.goal);
    for (const layer of [this.robot, this.bubbles, this.goal, this.blockages,
      this.obstacles, this.ground, this.otherPlaces, this.zones,
      this.routes, this.docks]) {
      layer.paint(theme);
    }
    this.draw();
  }

  private resize(): void {
    const { clientWidth, clientHeight } = this.host;
    if (clientWidth === 0 || clientHeight === 0) return;
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio));
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.camera.aspect = clientWidth / clientHeight;
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  // ---- the map ----

  setMap(info: AgentInfo, fields: HeightField[]): void {
    this.fields = fields;
    this.ground.clear();
    this.voxels.set(null);
    this.robot.build(info.robot);
    this.robot.paint(this.theme);
    this.shown = null;
    this.look('oblique');
  }

  addLevelPicture(field: HeightField, picture: ImageBitmap): void {
    this.ground.add(field, picture, this.theme);
    this.ground.show(this.level);
    this.draw();
  }

  setVoxels(mesh: VoxelMesh): void {
    this.voxels.set(mesh);
    this.applyCut();
  }

  showLevel(level: number): void {
    // So one looks at the other level from as far.
    const rise = (this.field(level)?.typical ?? 0) - (this.field()?.typical ?? 0);
    this.controls.target.z += rise;
    this.camera.position.z += rise;
    this.level = level;
    this.ground.show(level);
    this.drawZones();
    this.applyCut();
  }

  setCut(aboveGround: number): void {
    this.cutAboveGround = aboveGround;
    this.applyCut();
  }

  private applyCut(): void {
    const height = cutHeight(this.cutAboveGround, this.field()?.typical ?? 0,
        this.state?.pose ?? null, this.level);
    this.voxels.cutAt(height);
    this.ground.cutAt(height);
    this.draw();
  }

  show(layer: LayerName, isShown: boolean): void {
    if (isShown) this.hidden.delete(layer);
    else this.hidden.add(layer);
    this.applyVisibility();
  }

  private applyVisibility(): void {
    const isShown = (layer: LayerName): boolean => !this.hidden.has(layer);
    this.voxels.object.visible = isShown('octomap');
    this.ground.object.visible = isShown('ground');
    this.zones.object.visible = isShown('zones');
    this.costmap.object.visible = isShown('costmap') && this.hasCostmap;
    this.scan.object.visible = isShown('scan');
    this.particles.object.visible = isShown('particles');
    this.tree.object.visible = isShown('tree');
    this.routes.object.visible = isShown('route');
    this.docks.object.visible = isShown('docks');
    this.path.object.visible = isShown('path');
    this.bubbles.object.visible = isShown('bubbles');
    this.blockages.object.visible = isShown('blockages');
    this.robot.truth.visible = isShown('truth') && !!this.state?.truth;
    this.draw();
  }

  field(level = this.level): HeightField | null {
    return this.fields[level] ?? null;
  }

  private groundAt(x: number, y: number, level: number): number {
    return this.field(level)?.atOr(x, y, this.field(level)?.typical ?? 0) ?? 0;
  }

  // ---- zones ----

  setZones(zones: Zones): void {
    this.shownZones = zones;
    this.drawZones();
    this.draw();
  }

  setZoneDraft(corners: readonly Place[], level: number, kind: ZoneKind):
      void {
    this.zones.setDraft(
        corners, kind, (x, y) => this.groundAt(x, y, level));
    this.draw();
  }

  // ---- routes ----

  // Under way; null: none is.
  setRoute(route: Route | null): void {
    this.routes.set(route?.waypoints ?? [], route?.isLoop ?? false,
        (x, y, level) => this.groundAt(x, y, level));
    this.draw();
  }

  setRouteDraft(waypoints: readonly Waypoint[], isLoop: boolean): void {
    this.routes.setDraft(waypoints, isLoop,
        (x, y, level) => this.groundAt(x, y, level));
    this.draw();
  }

  // ---- docks ----

  setDocks(docks: readonly Dock[]): void {
    this.docks.set(docks, (x, y, level) => this.groundAt(x, y, level));
    this.draw();
  }

  private drawZones(): void {
    if (this.shownZones === null) return;
    this.zones.set(this.shownZones, this.field()?.level ?? null,
        (x, y) => this.groundAt(x, y, this.level));
  }

  // ---- what the agent says ----

  setState(state: RobotState): void {
    this.state = state;
    const { pose, truth } = state;
    this.wanted = pose === null ? null :
        { x: pose.x, y: pose.y, z: pose.height, yaw: pose.yaw };
    this.robot.place(this.robot.truth, truth === null ? null :
        { x: truth.x, y: truth.y, z: truth.height, yaw: truth.yaw });
    this.otherPlaces.set(pose?.inDoubt ? pose.others : []);
    const poses = isUnderWay(state.goal) ? state.goal.poses : [];
    this.goal.set(poses, (at) => this.groundAt(at.x, at.y, at.level));
    this.applyCut();
    this.applyVisibility();
  }

  setScene(scene: RobotScene): void {
    const field = this.field(this.state?.pose?.level ?? this.level);
    const ground = this.state?.pose?.height ?? field?.typical ?? 0;
    this.path.set(scene.path);
    this.bubbles.set(scene.bubbles);
    this.scan.set(scene.scan, ground);
    if (field !== null) {
      this.tree.set(scene.tree, field, ground);
      this.particles.set(scene.particles, field, ground);
    }
    this.blockages.set(
        scene.blockages, (x, y, level) => this.groundAt(x, y, level));
    this.obstacles.set(
        scene.obstacles, (x, y) => this.groundAt(x, y, this.level));
    // A lost robot has it elsewhere than where it then believes to be.
    const { costmap } = scene;
    this.hasCostmap = isAround(costmap, this.state?.pose ?? null) &&
        this.costmap.set(costmap, this.theme,
        (x, y) => field === null || field.at(x, y) !== null);
    this.applyVisibility();
  }

  // ---- looking ----

  look(angle: Angle): void {
    const field = this.field();
    if (field === null) return;
    const { width, height } = field.level;
    const box = new Box3();
    for (const [column, row] of [[0, 0], [width, 0], [0, height],
      [width, height]]) {
      const { x, y } = field.toMap(column, row);
      box.expandByPoint(new Vector3(x, y, field.lowest));
      box.expandByPoint(new Vector3(x, y, field.typical + DEFAULT_CUT_M));
    }
    const pixels = Math.max(200, this.host.clientHeight);
    const target = frameBox(
        this.camera, box, angle === 'top' ? 0.001 : TILT_RAD, {
          top: TOP_BAR_PX / pixels, bottom: BOTTOM_BAR_PX / pixels, side: 0.02,
        });
    this.controls.target.copy(target);
    this.controls.update();
    this.draw();
  }

  // Keeps the robot in the middle, and comes nearer if it is far off.
  follow(isOn: boolean): void {
    this.followsRobot = isOn;
    const away = this.camera.position.clone().sub(this.controls.target);
    if (isOn && away.length() > FOLLOW_FROM_M) {
      away.setLength(FOLLOW_FROM_M);
      this.camera.position.copy(this.controls.target).add(away);
    }
    this.draw();
  }

  private zoomBy(key: string): void {
    const share = key === '+' || key === '=' ? 0.15 : key === '-' ? -0.18 : 0;
    if (share === 0) return;
    this.camera.position.lerp(this.controls.target, share);
    this.controls.update();
    this.draw();
  }

  // A tool takes the first button and the first finger; the others move the
  // map.
  giveFirstButtonTo(taker: 'map' | 'tool'): void {
    const isMap = taker === 'map';
    this.controls.mouseButtons.LEFT = isMap ? MOUSE.PAN : null;
    this.controls.touches.ONE = isMap ? TOUCH.PAN : null;
    this.canvas.classList.toggle('is-aiming', !isMap);
  }

  // The ground of the shown level under a point of the window.
  groundUnder(clientX: number, clientY: number):
      { x: number; y: number; z: number } | null {
    const field = this.field();
    if (field === null) return null;
    const box = this.canvas.getBoundingClientRect();
    const at = new Vector2(
        ((clientX - box.left) / box.width) * 2 - 1,
        1 - ((clientY - box.top) / box.height) * 2);
    const ray = new Raycaster();
    ray.setFromCamera(at, this.camera);
    return field.pick(ray.ray.origin, ray.ray.direction);
  }

  // Where a point of the map is in the window, for tests and labels.
  windowOf(x: number, y: number, z: number): { x: number; y: number } {
    const box = this.canvas.getBoundingClientRect();
    const at = new Vector3(x, y, z).project(this.camera);
    return {
      x: box.left + ((at.x + 1) / 2) * box.width,
      y: box.top + ((1 - at.y) / 2) * box.height,
    };
  }

  // What the last picture was made of, for tests.
  drawn(): { triangles: number; levels: number } {
    return { triangles: this.renderer.info.render.triangles,
      levels: this.ground.shownLevels() };
  }

  // ---- drawing ----

  draw(): void {
    if (this.isDue) return;
    this.isDue = true;
    const rest = this.restsUntil - performance.now();
    if (rest > 0) window.setTimeout(() => this.drawSoon(), rest);
    else this.drawSoon();
  }

  // A browser that is not done with the last picture asks late for this one.
  private drawSoon(): void {
    const asked = performance.now();
    requestAnimationFrame((now) => {
      const began = performance.now();
      this.frame(now);
      this.restsUntil = performance.now() +
          restAfter(Math.max(began - asked, performance.now() - began));
    });
  }

  private frame(now: number): void {
    this.isDue = false;
    const passed = Math.min(200, now - this.lastFrame);
    this.lastFrame = now;
    const isGliding = this.glide(passed);
    this.renderer.render(this.scene, this.camera);
    this.onScale?.(this.pixelsPerMetre());
    // 30 pictures a second are smooth enough, and spare batteries.
    if (isGliding) window.setTimeout(() => this.draw(), 20);
  }

  private pixelsPerMetre(): number {
    const distance = this.camera.position.distanceTo(this.controls.target);
    const tangent = Math.tan((this.camera.fov * Math.PI) / 360);
    return this.host.clientHeight / (2 * tangent * distance);
  }

  // Moves the shown robot towards its newest pose; false when it is there.
  private glide(passedMs: number): boolean {
    const { shown, wanted } = this;
    if (wanted === null) {
      this.shown = null;
    } else if (shown === null ||
        Math.hypot(wanted.x - shown.x, wanted.y - shown.y) > 0.5) {
      this.shown = wanted;
    } else {
      const share = 1 - Math.exp(-passedMs / GLIDE_MS);
      const isThere =
          Math.hypot(wanted.x - shown.x, wanted.y - shown.y) < 0.004 &&
          Math.abs(turnBetween(shown.yaw, wanted.yaw, 1) - shown.yaw) < 0.01;
      this.shown = isThere ? wanted : {
        x: shown.x + share * (wanted.x - shown.x),
        y: shown.y + share * (wanted.y - shown.y),
        z: shown.z + share * (wanted.z - shown.z),
        yaw: turnBetween(shown.yaw, wanted.yaw, share),
      };
    }
    this.robot.place(this.robot.robot, this.shown);
    this.robot.placeDoubt(this.shown, this.state?.pose?.std ?? null);
    this.followTo(this.shown);
    return this.shown !== this.wanted;
  }

  private followTo(at: Stand | null): void {
    if (!this.followsRobot || at === null) return;
    const move = new Vector3(at.x, at.y, at.z).sub(this.controls.target);
    if (move.length() < 0.001) return;
    this.controls.target.add(move);
    this.camera.position.add(move);
    this.camera.lookAt(this.controls.target);
  }
}
