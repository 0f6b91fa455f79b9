// From the agent's JSON to what the page works with. What is wrong in shape is
// a DecodeError that names the field; what is missing gets a neutral value, so
// that an agent of a neighbouring version still shows.

import type {
  AgentInfo, Costmap, Fix, Goal, GoalState, LevelInfo, Pose, RobotEvent,
  RobotScene, RobotState, TrackedPose,
} from './types.js';

export class DecodeError extends Error {
  constructor(field: string, wanted: string) {
    super(`the agent's answer: "${field}" is not ${wanted}`);
    this.name = 'DecodeError';
  }
}

type Fields = Record<string, unknown>;

function fieldsOf(value: unknown, name: string): Fields {
  if (typeof value !== 'object' || value === null || Array.isArray(value)) {
    throw new DecodeError(name, 'an object');
  }
  return value as Fields;
}

function listOf(value: unknown, name: string): unknown[] {
  if (value === undefined || value === null) return [];
  if (!Array.isArray(value)) throw new DecodeError(name, 'a list');
  return value;
}

function isNumber(value: unknown): value is number {
  return typeof value === 'number' && Number.isFinite(value);
}

function needNumber(fields: Fields, name: string): number {
  const value = fields[name];
  if (!isNumber(value)) throw new DecodeError(name, 'a finite number');
  return value;
}

function numberOr<T>(fields: Fields, name: string, other: T): number | T {
  const value = fields[name];
  return isNumber(value) ? value : other;
}

function textOf(fields: Fields, name: string): string {
  const value = fields[name];
  return typeof value === 'string' ? value : '';
}

// A list of finite numbers, or of lists of them, as one flat list of groups.
// Groups with anything else in them are left out.
export function flatNumbers(
    value: unknown, group: number, name: string): Float32Array {
  const list = listOf(value, name);
  const flat = Array.isArray(list[0]) ? list.flat() : list;
  const out = new Float32Array(flat.length - (flat.length % group));
  let used = 0;
  for (let i = 0; i + group <= flat.length; i += group) {
    let isGood = true;
    for (let k = 0; k < group; ++k) {
      const entry = flat[i + k];
      isGood = isGood && isNumber(entry);
      out[used + k] = isNumber(entry) ? entry : 0;
    }
    if (isGood) used += group;
  }
  return out.slice(0, used);
}

function decodeLevel(value: unknown): LevelInfo {
  const fields = fieldsOf(value, 'levels');
  const [x = 0, y = 0, yaw = 0] = flatNumbers(fields.origin, 1, 'origin');
  const level = {
    index: needNumber(fields, 'index'),
    width: needNumber(fields, 'width'),
    height: needNumber(fields, 'height'),
    resolution: needNumber(fields, 'resolution_m'),
    origin: [x, y, yaw] as [number, number, number],
    minHeight: numberOr(fields, 'min_height_m', 0),
    maxHeight: numberOr(fields, 'max_height_m', 0),
  };
  if (!(level.resolution > 0)) {
    throw new DecodeError('resolution_m', 'above 0');
  }
  return level;
}

export function decodeInfo(value: unknown): AgentInfo {
  const fields = fieldsOf(value, 'info');
  const robot = fieldsOf(fields.robot ?? {}, 'robot');
  const map = fieldsOf(fields.map ?? {}, 'map');
  return {
    version: textOf(fields, 'version'),
    robot: {
      front: numberOr(robot, 'front_m', 0.3),
      rear: numberOr(robot, 'rear_m', 0.3),
      halfWidth: numberOr(robot, 'half_width_m', 0.3),
    },
    mapName: textOf(map, 'name'),
    levels: listOf(map.levels, 'levels').map(decodeLevel),
    simulated: fields.simulated === true,
    world: textOf(fields, 'world'),
    places: listOf(fields.places, 'places')
        .filter((place): place is string => typeof place === 'string'),
    server: textOf(fields, 'server'),
  };
}

function decodePose(value: unknown): Pose {
  const fields = fieldsOf(value, 'pose');
  return {
    x: needNumber(fields, 'x'),
    y: needNumber(fields, 'y'),
    yaw: numberOr(fields, 'yaw', 0),
    level: numberOr(fields, 'level', 0),
  };
}

function decodeTracked(value: unknown): TrackedPose | null {
  if (value === null || value === undefined) return null;
  const fields = fieldsOf(value, 'pose');
  return {
    ...decodePose(value),
    height: numberOr(fields, 'height_m', 0),
    std: numberOr(fields, 'std_m', null),
    stdYaw: numberOr(fields, 'std_rad', null),
  };
}

const GOAL_STATES: readonly string[] =
    ['accepted', 'active', 'succeeded', 'failed', 'cancelled'];

function decodeGoal(value: unknown): Goal | null {
  if (value === null || value === undefined) return null;
  const fields = fieldsOf(value, 'goal');
  const state = textOf(fields, 'state');
  return {
    id: needNumber(fields, 'id'),
    state: (GOAL_STATES.includes(state) ? state : 'unknown') as GoalState,
    cause: textOf(fields, 'cause'),
    why: textOf(fields, 'why'),
    toGo: numberOr(fields, 'to_go_m', 0),
    driven: numberOr(fields, 'driven_m', 0),
    replans: numberOr(fields, 'replans', 0),
    recoveries: numberOr(fields, 'recoveries', 0),
    poses: listOf(fields.poses, 'poses').map(decodePose),
  };
}

function decodeFix(value: unknown): Fix | null {
  if (value === null || value === undefined) return null;
  const fields = fieldsOf(value, 'fix');
  const x = numberOr(fields, 'x', null);
  const y = numberOr(fields, 'y', null);
  return {
    localized: fields.localized === true,
    confidence: numberOr(fields, 'confidence', null),
    inliers: numberOr(fields, 'inliers', null),
    samples: numberOr(fields, 'samples', null),
    scene: textOf(fields, 'scene'),
    reason: textOf(fields, 'reason'),
    roundTrip: numberOr(fields, 'round_trip_s', null),
    verdict: textOf(fields, 'verdict'),
    at: x === null || y === null ?
        null : { x, y, yaw: numberOr(fields, 'yaw', 0) },
  };
}

export function decodeState(value: unknown): RobotState {
  const fields = fieldsOf(value, 'state');
  const lost = fieldsOf(fields.lost ?? {}, 'lost');
  const command = fieldsOf(fields.command ?? {}, 'command');
  const truth = fields.truth ? fieldsOf(fields.truth, 'truth') : null;
  return {
    time: needNumber(fields, 'time_s'),
    mode: textOf(fields, 'mode'),
    cause: textOf(fields, 'cause'),
    causeText: textOf(fields, 'cause_text'),
    advice: textOf(fields, 'advice'),
    pose: decodeTracked(fields.pose),
    lost: {
      probability: numberOr(lost, 'probability', 0),
      state: textOf(lost, 'state'),
      reason: textOf(lost, 'reason'),
    },
    command: {
      forward: numberOr(command, 'forward_mps', 0),
      yawRate: numberOr(command, 'yaw_rate_radps', 0),
    },
    goal: decodeGoal(fields.goal),
    fix: decodeFix(fields.fix),
    devices: listOf(fields.devices, 'devices').map((entry) => {
      const device = fieldsOf(entry, 'devices');
      return {
        name: textOf(device, 'name'),
        state: textOf(device, 'state'),
        cause: textOf(device, 'cause'),
      };
    }),
    truth: truth === null ? null : {
      x: needNumber(truth, 'x'),
      y: needNumber(truth, 'y'),
      yaw: numberOr(truth, 'yaw', 0),
      height: numberOr(truth, 'height_m', 0),
    },
    missedDeadlines: numberOr(fields, 'missed_deadlines', 0),
    steps: numberOr(fields, 'steps', 0),
  };
}

function bytesOfBase64(text: string): Uint8Array {
  let binary: string;
  try {
    binary = atob(text);
  } catch {
    throw new DecodeError('cells', 'base64');
  }
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; ++i) bytes[i] = binary.charCodeAt(i);
  return bytes;
}

function decodeCostmap(value: unknown): Costmap | null {
  if (value === null || value === undefined) return null;
  const fields = fieldsOf(value, 'costmap');
  const [x = 0, y = 0] = flatNumbers(fields.origin, 1, 'origin');
  const width = needNumber(fields, 'width');
  const height = needNumber(fields, 'height');
  const cells = bytesOfBase64(textOf(fields, 'cells'));
  if (cells.length !== width * height) {
    throw new DecodeError('cells', `${width} x ${height} bytes`);
  }
  return {
    origin: [x, y],
    resolution: needNumber(fields, 'resolution_m'),
    width,
    height,
    z: numberOr(fields, 'z', 0),
    cells,
  };
}

export function decodeScene(value: unknown): RobotScene {
  const fields = fieldsOf(value, 'scene');
  const blockages = flatNumbers(fields.blockages, 4, 'blockages');
  const scene: RobotScene = {
    path: flatNumbers(fields.path, 4, 'path'),
    bubbles: flatNumbers(fields.bubbles, 4, 'bubbles'),
    tree: flatNumbers(fields.tree, 4, 'tree'),
    scan: flatNumbers(fields.scan, 2, 'scan'),
    particles: flatNumbers(fields.particles, 3, 'particles'),
    blockages: [],
    costmap: decodeCostmap(fields.costmap),
    obstacles: listOf(fields.obstacles, 'obstacles').map((entry) => {
      const obstacle = fieldsOf(entry, 'obstacles');
      return {
        name: textOf(obstacle, 'name'),
        x: needNumber(obstacle, 'x'),
        y: needNumber(obstacle, 'y'),
      };
    }),
  };
  for (let i = 0; i < blockages.length; i += 4) {
    scene.blockages.push({
      x: blockages[i], y: blockages[i + 1], radius: blockages[i + 2],
      level: blockages[i + 3],
    });
  }
  return scene;
}

export function decodeEvent(value: unknown): RobotEvent {
  const fields = fieldsOf(value, 'event');
  return {
    number: needNumber(fields, 'number'),
    time: numberOr(fields, 'time_s', 0),
    kind: textOf(fields, 'kind'),
    text: textOf(fields, 'text'),
  };
}
