// From the agent's messages to what the page works with: short names, null for
// what is not known, flat arrays for the graphics card.

import type { DescEnum } from '@bufbuild/protobuf';

import type { LevelPose } from '../gen/treeline/v1/navigation_pb.js';
import * as v1 from '../gen/treeline/v1/navigation_pb.js';
import * as v1b from '../gen/treeline/v1/battery_pb.js';
import * as v1d from '../gen/treeline/v1/docks_pb.js';
import * as v1r from '../gen/treeline/v1/routes_pb.js';
import * as v1z from '../gen/treeline/v1/zones_pb.js';
import type { Dock, Docking, Docks,
  AgentInfo, Battery, Costmap, Fix, Goal, GoalState, LevelInfo, Pose, RobotEvent,
  RobotScene, RobotState, Route, Routes, RouteStatus, TrackedPose, Zone,
  ZoneKind, Zones,
} from './types.js';

// A message that is one, and makes no sense.
export class ProtoError extends Error {
  constructor(field: string, wanted: string) {
    super(`the agent's answer: "${field}" is not ${wanted}`);
    this.name = 'ProtoError';
  }
}

// "safe_stop" of SAFE_STOP; '' of what this page does not know.
function wordOf(schema: DescEnum, value: number): string {
  return schema.value[value]?.localName.toLowerCase() ?? '';
}

const finiteOr = <T>(value: number, other: T): number | T =>
  Number.isFinite(value) ? value : other;

function needFinite(value: number, name: string): number {
  if (!Number.isFinite(value)) throw new ProtoError(name, 'a finite number');
  return value;
}

// Groups of numbers; those with one that is not finite are left out.
export function flatNumbers(values: number[], group: number): Float32Array {
  const out = new Float32Array(values.length - (values.length % group));
  let used = 0;
  for (let i = 0; i + group <= values.length; i += group) {
    let isGood = true;
    for (let k = 0; k < group; ++k) {
      isGood = isGood && Number.isFinite(values[i + k]);
      out[used + k] = values[i + k];
    }
    if (isGood) used += group;
  }
  return out.slice(0, used);
}

function levelOf(level: v1.MapLevel): LevelInfo {
  if (!(level.resolutionM > 0)) throw new ProtoError('resolution_m', 'above 0');
  return {
    index: level.index,
    width: level.width,
    height: level.height,
    resolution: level.resolutionM,
    origin: [level.originXM, level.originYM, level.originYawRad],
    minHeight: level.minHeightM,
    maxHeight: level.maxHeightM,
  };
}

// Of a robot that does not say.
const ROBOT_M = 0.3;

export function infoOf(info: v1.GetInfoResponse): AgentInfo {
  const { robot } = info;
  return {
    version: info.version,
    robot: {
      front: robot?.frontM ?? ROBOT_M,
      rear: robot?.rearM ?? ROBOT_M,
      halfWidth: robot?.halfWidthM ?? ROBOT_M,
    },
    mapName: info.mapName,
    levels: info.levels.map(levelOf),
    simulated: info.simulated,
    world: info.world,
    places: info.places,
    server: info.server,
  };
}

const planarOf = (pose: LevelPose) => ({
  x: needFinite(pose.xM, 'x_m'),
  y: needFinite(pose.yM, 'y_m'),
  yaw: finiteOr(pose.yawRad, 0),
});

const poseOf = (pose: LevelPose): Pose =>
  ({ ...planarOf(pose), level: pose.level });

// Standard deviations of a row-major 3x3 covariance of x, y and yaw: of the
// position, along the longer axis of its ellipse.
export function deviationsOf(
    covariance: number[]): { std: number | null; stdYaw: number | null } {
  if (covariance.length !== 9) return { std: null, stdYaw: null };
  const [a, b, , , d] = covariance;
  const longer = (a + d) / 2 + Math.hypot((a - d) / 2, b);
  return {
    std: finiteOr(Math.sqrt(Math.max(0, longer)), null),
    stdYaw: finiteOr(Math.sqrt(Math.max(0, covariance[8])), null),
  };
}

function trackedOf(state: v1.RobotState): TrackedPose | null {
  const pose = state.mapFromBase;
  if (pose === undefined) return null;
  return {
    ...poseOf(pose),
    height: finiteOr(pose.heightM, 0),
    ...deviationsOf(state.covariance),
    inDoubt: state.inDoubt,
    placeShare: finiteOr(state.placeShare, 0),
    others: state.otherPlaces.flatMap(({ mapFromBase, share }) =>
      mapFromBase === undefined ? [] : [{
        ...poseOf(mapFromBase),
        height: finiteOr(mapFromBase.heightM, 0),
        share: finiteOr(share, 0),
      }]),
  };
}

const GOAL_STATES: readonly string[] =
    ['accepted', 'active', 'succeeded', 'failed', 'cancelled'];

function goalOf(state: v1.RobotState): Goal | null {
  const { goal } = state;
  if (goal === undefined) return null;
  const word = wordOf(v1.GoalStateSchema, goal.state);
  return {
    id: Number(goal.id),
    state: (GOAL_STATES.includes(word) ? word : 'unknown') as GoalState,
    cause: causeOf(goal.cause),
    why: goal.why,
    toGo: finiteOr(goal.toGoM, 0),
    driven: finiteOr(goal.drivenM, 0),
    replans: goal.replans,
    recoveries: goal.recoveries,
    poses: state.goalPoses.map(poseOf),
  };
}

function causeOf(cause: v1.NavigationCause): string {
  return Number(cause) === 0 ? 'none' :
    wordOf(v1.NavigationCauseSchema, cause);
}

function fixOf(fix: v1.RelocalizationFix | undefined): Fix | null {
  if (fix === undefined) return null;
  return {
    localized: fix.localized,
    confidence: finiteOr(fix.confidence, null),
    inliers: fix.inliers,
    samples: fix.samples,
    scene: fix.scene,
    reason: fix.reason,
    roundTrip: finiteOr(fix.roundTripS, null),
    verdict: fix.verdict,
    at: fix.mapFromBase === undefined ? null : planarOf(fix.mapFromBase),
  };
}

function routeStatusOf(status: v1r.RouteStatus | undefined):
    RouteStatus | null {
  if (status === undefined) return null;
  return {
    id: Number(status.id),
    name: status.name,
    state: wordOf(v1r.RouteStateSchema, status.state),
    why: status.why,
    waypoint: status.waypoint,
    waypoints: status.waypoints,
    waypointName: status.waypointName,
    isLoop: status.loop,
    lap: Number(status.lap),
    waited: finiteOr(status.waitedS, 0),
    wait: finiteOr(status.waitS, 0),
    reached: Number(status.reached),
    missed: Number(status.missed),
    lastMissed: status.lastMissed.map(
        ({ waypoint, why }) => `waypoint ${waypoint + 1}: ${why}`),
    goalId: Number(status.goalId),
    warning: status.warning,
  };
}

function batteryOf(battery: v1b.BatteryStatus | undefined): Battery | null {
  if (battery === undefined) return null;
  return {
    volts: finiteOr(battery.voltageV, 0),
    charge: battery.charge === undefined ? null :
      finiteOr(battery.charge, null),
    charging: battery.charging === v1b.BatteryCharging.YES,
  };
}

function dockingOf(docking: v1d.DockingStatus | undefined): Docking | null {
  if (docking === undefined) return null;
  return {
    outcome: wordOf(v1d.DockingOutcomeSchema, docking.outcome),
    why: docking.why,
    failedTries: docking.failedTries,
    state: wordOf(v1d.DockingStateSchema, docking.state),
    dock: docking.dock,
    charge: wordOf(v1d.ChargeStateSchema, docking.chargeState),
    chargeWhy: docking.chargeWhy,
  };
}

export function stateOf(state: v1.RobotState): RobotState {
  const truth = state.trueMapFromBase;
  return {
    time: needFinite(state.timeS, 'time_s'),
    mode: wordOf(v1.NavigatorModeSchema, state.mode),
    cause: causeOf(state.cause),
    causeText: state.causeText,
    advice: state.advice,
    pose: trackedOf(state),
    lost: {
      probability: finiteOr(state.lostProbability, 0),
      state: state.lostState,
      reason: state.lostReason,
    },
    command: {
      forward: finiteOr(state.forwardMps, 0),
      yawRate: finiteOr(state.yawRateRadps, 0),
    },
    goal: goalOf(state),
    fix: fixOf(state.fix),
    devices: state.devices,
    truth: truth === undefined ? null :
        { ...planarOf(truth), height: finiteOr(truth.heightM, 0) },
    stop: state.stop === undefined ? null :
        { why: state.stop.why, since: finiteOr(state.stop.sinceS, 0) },
    zonesRevision: Number(state.zonesRevision),
    route: routeStatusOf(state.route),
    routesRevision: Number(state.routesRevision),
    battery: batteryOf(state.battery),
    docking: dockingOf(state.docking),
    docksRevision: Number(state.docking?.docksRevision ?? -1),
    missedDeadlines: Number(state.missedDeadlines),
    steps: Number(state.steps),
  };
}

function costmapOf(costmap: v1.CostmapWindow | undefined): Costmap | null {
  if (costmap === undefined) return null;
  const { width, height, cells } = costmap;
  if (cells.length !== width * height) {
    throw new ProtoError('cells', `${width} x ${height} bytes`);
  }
  return {
    origin: [costmap.originXM, costmap.originYM],
    resolution: costmap.resolutionM,
    width,
    height,
    z: costmap.heightM,
    cells,
  };
}

export function sceneOf(scene: v1.RobotScene): RobotScene {
  return {
    path: flatNumbers(scene.path.flatMap(
        (pose) => [pose.xM, pose.yM, pose.heightM, pose.yawRad]), 4),
    bubbles: flatNumbers(scene.bubbles.flatMap(
        (bubble) => [bubble.xM, bubble.yM, bubble.heightM, bubble.radiusM]), 4),
    tree: flatNumbers(scene.treeEdgesM, 4),
    scan: flatNumbers(scene.scanM, 2),
    particles: flatNumbers(scene.particles, 3),
    blockages: scene.blockages.map((blockage) => ({
      x: blockage.xM, y: blockage.yM, radius: blockage.radiusM,
      level: blockage.level,
    })),
    costmap: costmapOf(scene.costmap),
    obstacles: scene.obstacles.map(
        ({ name, xM, yM }) => ({ name, x: xM, y: yM })),
  };
}

const ZONE_KINDS: readonly [v1z.ZoneKind, ZoneKind][] = [
  [v1z.ZoneKind.KEEP_OUT, 'keep-out'], [v1z.ZoneKind.SPEED, 'speed'],
  [v1z.ZoneKind.ONE_WAY, 'one-way'],
];

// Of kinds that this page does not know: nothing.
const zoneKindOf = (kind: v1z.ZoneKind): ZoneKind | undefined =>
  ZONE_KINDS.find(([number]) => number === kind)?.[1];

export function zonesOf(message: v1z.GetZonesResponse): Zones {
  return {
    revision: Number(message.revision),
    zones: message.zones.flatMap((zone) => {
      const kind = zoneKindOf(zone.kind);
      return kind === undefined ? [] : [{
        name: zone.name,
        kind,
        level: zone.level,
        corners: zone.corners.map(({ xM, yM }) => (
          { x: needFinite(xM, 'x_m'), y: needFinite(yM, 'y_m') })),
        maxMps: zone.maxMps,
        direction: zone.directionRad,
      }];
    }),
    masks: message.masks.flatMap(({ name, kind: number, level, runs }) => {
      const kind = zoneKindOf(number);
      return kind === undefined ? [] : [{ name, kind, level, runs }];
    }),
    warning: message.warning,
  };
}

export function zoneToProto(zone: Zone) {
  return {
    name: zone.name,
    kind: ZONE_KINDS.find(([, kind]) => kind === zone.kind)?.[0] ??
      v1z.ZoneKind.UNSPECIFIED,
    level: zone.level,
    corners: zone.corners.map(({ x, y }) => ({ xM: x, yM: y })),
    maxMps: zone.maxMps,
    directionRad: zone.direction,
  };
}

const routeOf = (route: v1r.Route): Route => ({
  name: route.name,
  isLoop: route.loop,
  stopsAtMissed: route.whenMissed === v1r.MissedPolicy.STOP,
  waypoints: route.waypoints.map((waypoint) => ({
    x: needFinite(waypoint.xM, 'x_m'),
    y: needFinite(waypoint.yM, 'y_m'),
    level: waypoint.level,
    yaw: waypoint.yawRad === undefined ? null : finiteOr(waypoint.yawRad, null),
    wait: finiteOr(waypoint.waitS, 0),
    name: waypoint.name,
  })),
});

export function routesOf(message: v1r.GetRoutesResponse): Routes {
  return {
    revision: Number(message.revision),
    routes: message.routes.map(routeOf),
    current: message.current === undefined ? null : routeOf(message.current),
    warning: message.warning,
  };
}

export function routeToProto(route: Route) {
  return {
    name: route.name,
    loop: route.isLoop,
    whenMissed: route.stopsAtMissed ? v1r.MissedPolicy.STOP :
      v1r.MissedPolicy.GO_ON,
    waypoints: route.waypoints.map(({ x, y, level, yaw, wait, name }) => ({
      xM: x, yM: y, level, waitS: wait, name,
      ...yaw !== null && { yawRad: yaw },
    })),
  };
}

export function docksOf(message: v1d.GetDocksResponse): Docks {
  return {
    revision: Number(message.revision),
    docks: message.docks.map((dock) => ({
      name: dock.name,
      x: needFinite(dock.xM, 'x_m'),
      y: needFinite(dock.yM, 'y_m'),
      yaw: needFinite(dock.yawRad, 'yaw_rad'),
      level: dock.level,
      isBackward: dock.backward,
    })),
    warning: message.warning,
  };
}

export const dockToProto = ({ name, x, y, yaw, level, isBackward }: Dock) =>
  ({ name, xM: x, yM: y, yawRad: yaw, level, backward: isBackward });

export function eventOf(event: v1.RobotEvent): RobotEvent {
  return {
    number: Number(event.number),
    time: finiteOr(event.timeS, 0),
    kind: event.kind,
    text: event.text,
  };
}
