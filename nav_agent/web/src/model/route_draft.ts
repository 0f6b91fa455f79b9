// A route that is being drawn, waypoint by waypoint, and routes in words.

import type { Route, RouteStatus, Waypoint } from '../api/types.js';
import type { Saying, Tone } from './words.js';

// What the agent takes.
export const MOST_WAYPOINTS = 100;
export const LONGEST_WAIT_S = 86400;
export const MOST_NAME_BYTES = 64;
// A click so near to the one before is a double click (m).
const SAME_M = 0.05;

export class RouteDraft {
  readonly waypoints: Waypoint[] = [];

  // Whether it is a waypoint more.
  add(waypoint: Omit<Waypoint, 'wait' | 'name'>): boolean {
    const last = this.waypoints.at(-1);
    const isSame = last !== undefined && last.level === waypoint.level &&
        Math.hypot(last.x - waypoint.x, last.y - waypoint.y) < SAME_M;
    if (isSame || this.waypoints.length >= MOST_WAYPOINTS) return false;
    this.waypoints.push({ ...waypoint, wait: 0, name: '' });
    return true;
  }

  undo(): void {
    this.waypoints.pop();
  }

  clear(): void {
    this.waypoints.length = 0;
  }

  // At the newest waypoint (s). What is no time is none.
  setWait(seconds: number): void {
    const last = this.waypoints.at(-1);
    if (last === undefined) return;
    last.wait = Number.isFinite(seconds) ?
      Math.min(LONGEST_WAIT_S, Math.max(0, seconds)) : 0;
  }

  get lastWait(): number {
    return this.waypoints.at(-1)?.wait ?? 0;
  }

  route(name: string, isLoop: boolean, stopsAtMissed: boolean): Route {
    return {
      name: name.trim(), isLoop, stopsAtMissed,
      waypoints: this.waypoints.map((waypoint) => ({ ...waypoint })),
    };
  }
}

// "Route 2": the first such name that is free.
export function freeRouteName(routes: readonly Route[]): string {
  const names = new Set(routes.map(({ name }) => name));
  for (let i = 1; ; ++i) {
    if (!names.has(`Route ${i}`)) return `Route ${i}`;
  }
}

const count = (number: number, what: string): string =>
  `${number} ${what}${number === 1 ? '' : 's'}`;

// What a route says, for a list.
export function routeDetail(route: Route): string {
  const waits = route.waypoints.reduce((sum, { wait }) => sum + wait, 0);
  return [
    count(route.waypoints.length, 'waypoint'),
    ...route.isLoop ? ['in a loop'] : [],
    ...waits > 0 ? [`waits ${waits} s`] : [],
    ...route.stopsAtMissed ? ['stops at a missed one'] : [],
  ].join(', ');
}

export const isRouteOpen = (route: RouteStatus | null): route is RouteStatus =>
  route !== null &&
  ['driving', 'waiting', 'held', 'offered'].includes(route.state);

// One that somebody must say of that it goes on.
export const mayGoOn = (route: RouteStatus | null): boolean =>
  route !== null && ['held', 'offered'].includes(route.state);

const OUTCOMES: Record<string, [word: string, tone: Tone]> = {
  driving: ['', 'busy'], waiting: ['waits', 'busy'],
  held: ['held', 'warn'], offered: ['not resumed yet', 'warn'],
  succeeded: ['done', 'calm'], failed: ['failed', 'bad'],
  cancelled: ['given up', 'warn'],
};

// How far the robot is on its route.
export function sayRoute(route: RouteStatus): Saying {
  const [word, tone] = OUTCOMES[route.state] ?? ['', 'calm'];
  const name = route.name === '' ? 'Route' : route.name;
  const at = `waypoint ${route.waypoint + 1} of ${route.waypoints}` +
      (route.waypointName === '' ? '' : ` (${route.waypointName})`);
  const lap = route.isLoop ? `, lap ${route.lap + 1}` : '';
  const wait = route.state === 'waiting' ?
    ` ${Math.floor(route.waited)} of ${Math.round(route.wait)} s` : '';
  const parts = [
    ...route.why === '' ? [] : [route.why],
    ...route.missed === 0 ? [] : [`${count(route.missed, 'waypoint')} missed: ` +
      `${route.lastMissed.at(-1) ?? ''}`],
    ...route.warning === '' || !isRouteOpen(route) ? [] : [route.warning],
  ];
  return {
    title: isRouteOpen(route) ?
      `${name}: ${at}${lap}${word === '' ? '' : `, ${word}${wait}`}` :
      `${name}: ${word}`,
    text: parts.join(' — '),
    tone: route.state === 'succeeded' && route.missed > 0 ? 'warn' : tone,
  };
}
