// What the agent says and takes. docs/reference/agent.md has the fields.
// Lengths in m, angles in rad, times in s, in the map's frame (x forward, y
// left, z up).

export interface Pose {
  x: number;
  y: number;
  yaw: number;
  level: number;
}

// Where else a robot in doubt may be; its share of all places, in (0, 1).
export interface PossiblePlace extends Pose {
  height: number;
  share: number;
}

export interface TrackedPose extends Pose {
  height: number;
  // Standard deviations; null where the agent has none.
  std: number | null;
  stdYaw: number | null;
  // Whether places that are alike are not excluded yet, the share of this one
  // among them, and the likeliest others.
  inDoubt: boolean;
  placeShare: number;
  others: PossiblePlace[];
}

export interface LevelInfo {
  index: number;
  width: number;
  height: number;
  resolution: number;
  // The lower left corner of the grid, and its rotation.
  origin: [x: number, y: number, yaw: number];
  minHeight: number;
  maxHeight: number;
}

export interface AgentInfo {
  version: string;
  robot: { front: number; rear: number; halfWidth: number };
  mapName: string;
  levels: LevelInfo[];
  simulated: boolean;
  world: string;
  places: string[];
  server: string;
}

export type GoalState =
  | 'accepted' | 'active' | 'succeeded' | 'failed' | 'cancelled' | 'unknown';

export interface Goal {
  id: number;
  state: GoalState;
  cause: string;
  why: string;
  toGo: number;
  driven: number;
  replans: number;
  recoveries: number;
  poses: Pose[];
}

// The server's last answer and what became of it.
export interface Fix {
  localized: boolean;
  confidence: number | null;
  inliers: number | null;
  samples: number | null;
  scene: string;
  reason: string;
  roundTrip: number | null;
  verdict: string;
  at: { x: number; y: number; yaw: number } | null;
}

export interface Device {
  name: string;
  state: string;
  cause: string;
}

export type ZoneKind = 'keep-out' | 'speed' | 'one-way';

export interface Zone {
  name: string;
  kind: ZoneKind;
  level: number;
  corners: { x: number; y: number }[];
  // Of a speed zone (m/s), and of a one-way zone (rad).
  maxMps: number;
  direction: number;
}

export interface ZoneMask {
  name: string;
  kind: ZoneKind;
  level: number;
  // Row, first column, and the column after the last, of each run of cells.
  runs: number[];
}

export interface Zones {
  revision: number;
  zones: Zone[];
  masks: ZoneMask[];
  // Why a restart does not find them; '' if it does.
  warning: string;
}

export interface Waypoint {
  x: number;
  y: number;
  level: number;
  // null: where the way leads on.
  yaw: number | null;
  wait: number;
  name: string;
}

export interface Route {
  name: string;
  waypoints: Waypoint[];
  isLoop: boolean;
  // When a waypoint cannot be reached; else it goes on to the next.
  stopsAtMissed: boolean;
}

export interface Routes {
  revision: number;
  routes: Route[];
  // Under way, held or offered.
  current: Route | null;
  // Why a restart does not find them; '' if it does.
  warning: string;
}

// docs/reference/routes.md: "driving", "waiting", "held", "offered",
// "succeeded", "failed", "cancelled"; '' of what this page does not know.
export interface RouteStatus {
  id: number;
  name: string;
  state: string;
  why: string;
  // From 0, and how many there are.
  waypoint: number;
  waypoints: number;
  waypointName: string;
  isLoop: boolean;
  lap: number;
  waited: number;
  wait: number;
  reached: number;
  missed: number;
  // In words, the newest last.
  lastMissed: string[];
  goalId: number;
  // Why a restart does not find it; '' if it does.
  warning: string;
}

export interface Battery {
  // 0: it does not tell.
  volts: number;
  // Of a full one, in [0, 1]; null: it does not tell.
  charge: number | null;
  charging: boolean;
}

// Where the robot stands in it.
export interface Dock extends Pose {
  name: string;
  isBackward: boolean;
}

export interface Docks {
  revision: number;
  docks: Dock[];
  // Why a restart does not find them; '' if it does.
  warning: string;
}

// docs/reference/docks.md, in words with an underscore between them; '' of what
// this page does not know.
export interface Docking {
  outcome: string;
  why: string;
  failedTries: number;
  state: string;
  dock: string;
  charge: string;
  chargeWhy: string;
}

export interface RobotState {
  time: number;
  mode: string;
  cause: string;
  causeText: string;
  advice: string;
  pose: TrackedPose | null;
  lost: { probability: number; state: string; reason: string };
  command: { forward: number; yawRate: number };
  goal: Goal | null;
  fix: Fix | null;
  devices: Device[];
  // Only in simulation.
  truth: { x: number; y: number; yaw: number; height: number } | null;
  // Holds until it is released; null: nobody has stopped it.
  stop: { why: string; since: number } | null;
  // Of the zones that there are now.
  zonesRevision: number;
  // The last one; null: there was none.
  route: RouteStatus | null;
  routesRevision: number;
  // null: the robot does not tell.
  battery: Battery | null;
  // null: the agent knows no docks.
  docking: Docking | null;
  docksRevision: number;
  missedDeadlines: number;
  steps: number;
}

export interface Costmap {
  origin: [x: number, y: number];
  resolution: number;
  width: number;
  height: number;
  z: number;
  // Rows from the bottom: 0 free, 1 obstacle of the map, 2 one that was seen.
  cells: Uint8Array;
}

export interface RobotScene {
  // x, y, z, yaw of each pose.
  path: Float32Array;
  // x, y, z, radius of each bubble.
  bubbles: Float32Array;
  // x0, y0, x1, y1 of each edge.
  tree: Float32Array;
  // x, y of each point.
  scan: Float32Array;
  // x, y, yaw of each particle.
  particles: Float32Array;
  blockages: { x: number; y: number; radius: number; level: number }[];
  costmap: Costmap | null;
  obstacles: { name: string; x: number; y: number }[];
}

export interface RobotEvent {
  number: number;
  time: number;
  kind: string;
  text: string;
}
