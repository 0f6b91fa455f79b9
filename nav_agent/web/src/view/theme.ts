// Colours of the map's picture, for a light and a dark room.

import type { ZoneKind } from '../api/types.js';

export interface Theme {
  background: number;
  free: [number, number, number];
  occupied: [number, number, number];
  grid: number;
  robot: number;
  robotTop: number;
  truth: number;
  path: number;
  bubble: number;
  tree: number;
  scan: number;
  particle: number;
  goal: number;
  route: number;
  dock: number;
  blockage: number;
  obstacle: number;
  costMap: [number, number, number];
  costSeen: [number, number, number];
  zones: Record<ZoneKind, number>;
}

export const LIGHT: Theme = {
  background: 0xe9eeea,
  free: [250, 251, 249],
  occupied: [74, 86, 80],
  grid: 0xc9d3cc,
  robot: 0x17624a,
  robotTop: 0xffffff,
  truth: 0x0a7ea4,
  path: 0xd02c2c,
  bubble: 0x1d9a4b,
  tree: 0x3f6fd1,
  scan: 0xc2185b,
  particle: 0x7b3fc4,
  goal: 0x1f5fd0,
  route: 0x00796b,
  dock: 0x8d5a00,
  blockage: 0xb3261e,
  obstacle: 0xb8741a,
  costMap: [110, 96, 160],
  costSeen: [232, 120, 20],
  zones: { 'keep-out': 0xc62828, 'speed': 0xb26a00, 'one-way': 0x1565c0 },
};

export const DARK: Theme = {
  background: 0x121815,
  free: [58, 69, 63],
  occupied: [150, 165, 157],
  grid: 0x27302b,
  robot: 0x4fc796,
  robotTop: 0x0d1411,
  truth: 0x5cc8ee,
  path: 0xff5a52,
  bubble: 0x58d987,
  tree: 0x7aa2ff,
  scan: 0xff6fa8,
  particle: 0xb892ff,
  goal: 0x7fb0ff,
  route: 0x4dd0c0,
  dock: 0xffc46b,
  blockage: 0xff8a80,
  obstacle: 0xe6b05a,
  costMap: [150, 136, 210],
  costSeen: [255, 160, 60],
  zones: { 'keep-out': 0xff7b72, 'speed': 0xffb74d, 'one-way': 0x64b5f6 },
};

const preference = (): MediaQueryList =>
  window.matchMedia('(prefers-color-scheme: dark)');

export function currentTheme(): Theme {
  return preference().matches ? DARK : LIGHT;
}

export function onThemeChange(work: () => void): void {
  preference().addEventListener('change', work);
}
