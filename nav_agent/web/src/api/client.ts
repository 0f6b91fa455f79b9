// Commands to the agent, and what is fetched from it once. Commands go over
// Connect; maps and pictures are files.

import { Code, ConnectError, createClient, type CallOptions, type Client,
  type Transport } from '@connectrpc/connect';

import {
  NavigationService, SimulationService, type StreamStateResponse,
} from '../gen/treeline/v1/navigation_pb.js';
import { DockingService } from '../gen/treeline/v1/docks_pb.js';
import {
  docksOf, dockToProto, infoOf, routesOf, routeToProto, zonesOf, zoneToProto,
} from './from_proto.js';
import type {
  AgentInfo, Dock, Docks, Pose, Route, Routes, Zone, Zones,
} from './types.js';

// What the agent answered, or why there is no answer, for people.
export class ApiError extends Error {
  constructor(readonly code: string, message: string) {
    super(message);
    this.name = 'ApiError';
  }
}

export type Fetch = (url: string, init?: RequestInit) => Promise<Response>;

// Of what happened before the page came.
const PAST_EVENTS = 50;

const levelPose = ({ x, y, yaw, level }: Pose) =>
  ({ xM: x, yM: y, yawRad: yaw, level });

export class AgentClient {
  private readonly navigation: Client<typeof NavigationService>;
  private readonly docking: Client<typeof DockingService>;
  private readonly simulation: Client<typeof SimulationService>;

  constructor(
      transport: Transport, private readonly fetch: Fetch,
      private readonly timeoutMs = 8000) {
    this.navigation = createClient(NavigationService, transport);
    this.docking = createClient(DockingService, transport);
    this.simulation = createClient(SimulationService, transport);
  }

  info(): Promise<AgentInfo> {
    return this.call(async (options) =>
      infoOf(await this.navigation.getInfo({}, options)));
  }

  watch(signal: AbortSignal): AsyncIterable<StreamStateResponse> {
    return this.navigation.streamState(
        { pastEvents: PAST_EVENTS, withScene: true }, { signal });
  }

  sendGoal(poses: Pose[]): Promise<void> {
    return this.call(async (options) => {
      const feedback = this.navigation.navigate(
          { poses: poses.map(levelPose), keepWhenCallEnds: true }, options);
      // From its first answer on the goal is the robot's own: the stream of
      // states tells the rest.
      for await (const _ of feedback) return;
    });
  }

  setPose(pose: Pose): Promise<void> {
    return this.call((options) => this.navigation.setInitialPose(
        { mapFromBase: levelPose(pose) }, options)).then(() => {});
  }

  cancel = (): Promise<void> =>
    this.call((options) => this.navigation.cancel({}, options)).then(() => {});
  pause = (): Promise<void> =>
    this.call((options) => this.navigation.pause({}, options)).then(() => {});
  resume = (): Promise<void> =>
    this.call((options) => this.navigation.resume({}, options)).then(() => {});
  // What is wrong with keeping it; '' if nothing is.
  stop = (): Promise<string> =>
    this.call((options) => this.navigation.stop(
        { why: 'stopped on the operator\'s page' }, options))
        .then(({ warning }) => warning);
  release = (): Promise<string> =>
    this.call((options) => this.navigation.release({}, options))
        .then(({ warning }) => warning);

  drive(forwardMps: number, yawRateRadps: number, driver: string,
      sequence: bigint): Promise<void> {
    return this.call((options) => this.navigation.drive(
        { forwardMps, yawRateRadps, driver, sequence }, options))
        .then(() => {});
  }

  zones(): Promise<Zones> {
    return this.call(async (options) =>
      zonesOf(await this.navigation.getZones({}, options)));
  }

  // What is wrong with keeping it; '' if nothing is.
  putZone(zone: Zone): Promise<string> {
    return this.call((options) => this.navigation.putZones(
        { zones: [zoneToProto(zone)] }, options))
        .then(({ warning }) => warning);
  }

  removeZone(name: string): Promise<void> {
    return this.call((options) => this.navigation.removeZones(
        { names: [name] }, options)).then(() => {});
  }

  routes(): Promise<Routes> {
    return this.call(async (options) =>
      routesOf(await this.navigation.getRoutes({}, options)));
  }

  // What is wrong with keeping it; '' if nothing is.
  putRoute(route: Route): Promise<string> {
    return this.call((options) => this.navigation.putRoutes(
        { routes: [routeToProto(route)] }, options))
        .then(({ warning }) => warning);
  }

  removeRoute(name: string): Promise<void> {
    return this.call((options) => this.navigation.removeRoutes(
        { names: [name] }, options)).then(() => {});
  }

  // One that is kept, by its name, or this one.
  runRoute(route: Route | string): Promise<void> {
    return this.call(async (options) => {
      const what = typeof route === 'string' ?
        { case: 'kept' as const, value: route } :
        { case: 'route' as const, value: routeToProto(route) };
      const feedback = this.navigation.runRoute(
          { what, keepWhenCallEnds: true }, options);
      // As with a goal.
      for await (const _ of feedback) return;
    });
  }

  resumeRoute = (): Promise<void> =>
    this.call((options) => this.navigation.resumeRoute({}, options))
        .then(() => {});
  cancelRoute = (): Promise<void> =>
    this.call((options) => this.navigation.cancelRoute({}, options))
        .then(() => {});

  docks(): Promise<Docks> {
    return this.call(async (options) =>
      docksOf(await this.docking.getDocks({}, options)));
  }

  // isHere: at the robot's pose, not at the dock's. What is wrong with keeping
  // it; '' if nothing is.
  putDock(dock: Dock, isHere: boolean): Promise<string> {
    return this.call((options) => this.docking.putDocks(
        { docks: [dockToProto(dock)], here: isHere }, options))
        .then(({ warning }) => warning);
  }

  removeDock(name: string): Promise<void> {
    return this.call((options) => this.docking.removeDocks(
        { names: [name] }, options)).then(() => {});
  }

  dock(name: string): Promise<void> {
    return this.call(async (options) => {
      const feedback = this.docking.dock(
          { name, keepWhenCallEnds: true }, options);
      // As with a goal.
      for await (const _ of feedback) return;
    });
  }

  undock = (): Promise<void> =>
    this.call((options) => this.docking.undock({}, options)).then(() => {});

  findYourself = (): Promise<void> =>
    this.call((options) => this.navigation.findYourself({}, options))
        .then(() => {});

  // To a pose, to a place of the world, or anywhere.
  kidnapTo(target: Pose | { place: string } | null): Promise<void> {
    const to = target === null ? { case: undefined } : 'place' in target ?
      { case: 'place' as const, value: target.place } :
      { case: 'mapFromBase' as const, value: levelPose(target) };
    return this.call((options) => this.simulation.kidnap({ to }, options))
        .then(() => {});
  }

  addObstacle(x: number, y: number, level: number, sizeM: number):
      Promise<void> {
    return this.call((options) => this.simulation.addObstacle(
        { xM: x, yM: y, level, sizeM }, options)).then(() => {});
  }

  removeObstacle(name: string): Promise<void> {
    return this.call((options) => this.simulation.removeObstacle(
        { name }, options)).then(() => {});
  }

  injectFault(target: string, kind: string, durationS: number): Promise<void> {
    return this.call((options) => this.simulation.injectFault(
        { target, kind, durationS }, options)).then(() => {});
  }

  async bytes(path: string): Promise<ArrayBuffer> {
    return (await this.get(path)).arrayBuffer();
  }

  async picture(path: string): Promise<Blob> {
    return (await this.get(path)).blob();
  }

  // What a call gives, or an ApiError. Nothing of the call stays open.
  private async call<T>(ask: (options: CallOptions) => Promise<T>): Promise<T> {
    const abort = new AbortController();
    try {
      return await ask({ signal: abort.signal, timeoutMs: this.timeoutMs });
    } catch (error) {
      throw apiErrorOf(error);
    } finally {
      abort.abort();
    }
  }

  // A response with a good status, or an ApiError.
  private async get(path: string): Promise<Response> {
    const abort = new AbortController();
    const timer = setTimeout(() => abort.abort(), this.timeoutMs);
    try {
      const response = await this.fetch(
          path, { cache: 'no-cache', signal: abort.signal });
      if (!response.ok) throw await refusalOf(response);
      return response;
    } catch (error) {
      if (error instanceof ApiError) throw error;
      throw abort.signal.aborted ? timeout() : unreachable();
    } finally {
      clearTimeout(timer);
    }
  }
}

const timeout = (): ApiError =>
  new ApiError('timeout', 'The agent did not answer in time.');
const unreachable = (): ApiError =>
  new ApiError('unreachable', 'The agent cannot be reached.');

// What Connect itself says of a call that took too long; the agent has words of
// its own.
const TIMED_OUT = 'the operation timed out';

// "invalid_argument" of InvalidArgument.
const nameOf = (code: Code): string =>
  Code[code].replace(/(?!^)[A-Z]/g, '_$&').toLowerCase();

function apiErrorOf(error: unknown): Error {
  const connect = ConnectError.from(error);
  if (connect.cause instanceof TypeError) return unreachable();
  if (connect.rawMessage === TIMED_OUT) return timeout();
  // Not of the agent: a defect of the page, or an answer that makes no sense.
  if (!(error instanceof ConnectError)) {
    return error instanceof Error ? error : connect;
  }
  const name = nameOf(connect.code);
  return new ApiError(name, connect.rawMessage === '' ?
    `The agent answered "${name.replace(/_/g, ' ')}".` : connect.rawMessage);
}

// {"error":{"code","message"}}; anything else is told by its status.
async function refusalOf(response: Response): Promise<ApiError> {
  const status = `The agent answered with status ${response.status}.`;
  try {
    const body = await response.json() as
        { error?: { code?: unknown; message?: unknown } };
    const { code, message } = body.error ?? {};
    return new ApiError(
        typeof code === 'string' ? code : `http_${response.status}`,
        typeof message === 'string' && message !== '' ? message : status);
  } catch {
    return new ApiError(`http_${response.status}`, status);
  }
}
