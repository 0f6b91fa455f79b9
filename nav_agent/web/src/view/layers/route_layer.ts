// Routes on the ground: the one under way, and one that is being drawn.

import {
  BufferGeometry, Float32BufferAttribute, Group, Line, LineBasicMaterial,
  LineLoop,
} from 'three';

import type { Waypoint } from '../../api/types.js';
import { headingTowards } from '../../model/gesture.js';
import type { Theme } from '../theme.js';
import { PoseMarks } from './mark_layers.js';

type HeightAt = (x: number, y: number, level: number) => number;

// Above the ground, so that it is not hidden by it (m).
const RAISED_M = 0.08;
const MARK_SCALE = 0.6;

// Waypoints with their headings, and lines between them.
class RouteMarks {
  readonly object = new Group();
  private readonly line = new LineBasicMaterial({
    transparent: true, opacity: 0.7, depthTest: false });
  private readonly marks = new PoseMarks(MARK_SCALE);
  private way: Line | null = null;

  constructor() {
    this.object.add(this.marks.object);
  }

  paint(colour: number): void {
    this.line.color.set(colour);
    this.marks.paint(colour);
  }

  set(waypoints: readonly Waypoint[], isLoop: boolean, heightAt: HeightAt):
      void {
    this.marks.set(waypoints.map((at, i) => {
      // Without a heading it looks to where the way leads on.
      const next = waypoints[i + 1] ?? (isLoop ? waypoints[0] : undefined);
      const yaw = at.yaw ?? (next === undefined ?
        headingTowards(waypoints[i - 1] ?? null, at) :
        headingTowards(at, next));
      return { ...at, yaw };
    }), ({ x, y, level }) => heightAt(x, y, level));
    this.setWay(waypoints, isLoop, heightAt);
  }

  private setWay(waypoints: readonly Waypoint[], isLoop: boolean,
      heightAt: HeightAt): void {
    if (this.way !== null) {
      this.way.geometry.dispose();
      this.object.remove(this.way);
      this.way = null;
    }
    if (waypoints.length < 2) return;
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new Float32BufferAttribute(
        waypoints.flatMap(({ x, y, level }) =>
          [x, y, heightAt(x, y, level) + RAISED_M]), 3));
    this.way = isLoop ? new LineLoop(geometry, this.line) :
      new Line(geometry, this.line);
    this.way.renderOrder = 4;
    this.way.frustumCulled = false;
    this.object.add(this.way);
  }
}

export class RouteLayer {
  readonly object = new Group();
  private readonly current = new RouteMarks();
  private readonly draft = new RouteMarks();

  constructor() {
    this.object.add(this.current.object, this.draft.object);
  }

  paint(theme: Theme): void {
    this.current.paint(theme.route);
    this.draft.paint(theme.goal);
  }

  set(waypoints: readonly Waypoint[], isLoop: boolean, heightAt: HeightAt):
      void {
    this.current.set(waypoints, isLoop, heightAt);
  }

  setDraft(waypoints: readonly Waypoint[], isLoop: boolean,
      heightAt: HeightAt): void {
    this.draft.set(waypoints, isLoop, heightAt);
  }
}
