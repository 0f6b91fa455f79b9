// The local costmap, as a sheet over the ground around the robot.

import {
  DataTexture, Mesh, MeshBasicMaterial, NearestFilter, PlaneGeometry,
  RGBAFormat, UnsignedByteType,
} from 'three';

import type { Costmap } from '../../api/types.js';
import type { Theme } from '../theme.js';

// How much is seen of it, of 255: what lies below shall be, too.
const SEEN_ALPHA = 215;
const RIM_ALPHA = 125;
const MAPPED_ALPHA = 85;
const FREE_ALPHA = 12;

// Whether the place is in it.
export function isAround(
    map: Costmap | null, place: { x: number; y: number } | null): boolean {
  if (map === null || place === null) return false;
  const column = (place.x - map.origin[0]) / map.resolution;
  const row = (place.y - map.origin[1]) / map.resolution;
  return column >= 0 && row >= 0 && column < map.width && row < map.height;
}

export class CostmapLayer {
  private readonly material = new MeshBasicMaterial({
    transparent: true, depthWrite: false, polygonOffset: true,
    polygonOffsetFactor: -2, polygonOffsetUnits: -4,
  });
  readonly object = new Mesh(new PlaneGeometry(1, 1), this.material);
  private texture: DataTexture | null = null;

  constructor() {
    this.object.renderOrder = 1;
    this.object.visible = false;
  }

  // Whether there is one to show. Where `hasGround` says that the map has none,
  // only what sensors see is drawn: nothing is beside a building.
  set(map: Costmap | null, theme: Theme,
      hasGround: (x: number, y: number) => boolean): boolean {
    if (map === null || map.width * map.height === 0) return false;
    const pixels = new Uint8Array(4 * map.cells.length);
    map.cells.forEach((cell, i) => {
      const [x, y] = [i % map.width, Math.floor(i / map.width)];
      const isIn = hasGround(
          map.origin[0] + (x + 0.5) * map.resolution,
          map.origin[1] + (y + 0.5) * map.resolution);
      const isRim = x === 0 || y === 0 || x + 1 === map.width ||
          y + 1 === map.height;
      const colour = cell === 2 ? theme.costSeen : theme.costMap;
      const alpha = cell === 2 ? SEEN_ALPHA : !isIn ? 0 :
        isRim ? RIM_ALPHA : cell === 1 ? MAPPED_ALPHA : FREE_ALPHA;
      pixels.set([...colour, alpha], 4 * i);
    });
    this.texture?.dispose();
    this.texture = new DataTexture(
        pixels, map.width, map.height, RGBAFormat, UnsignedByteType);
    this.texture.magFilter = NearestFilter;
    this.texture.needsUpdate = true;
    this.material.map = this.texture;
    this.material.needsUpdate = true;
    const width = map.width * map.resolution;
    const height = map.height * map.resolution;
    this.object.scale.set(width, height, 1);
    this.object.position.set(
        map.origin[0] + width / 2, map.origin[1] + height / 2, map.z + 0.05);
    return true;
  }
}
