// Docks on the ground: where the robot stands in them.

import type { Dock } from '../../api/types.js';
import type { Theme } from '../theme.js';
import { PoseMarks } from './mark_layers.js';

const MARK_SCALE = 0.6;

export class DockLayer {
  private readonly marks = new PoseMarks(MARK_SCALE);
  readonly object = this.marks.object;

  paint(theme: Theme): void {
    this.marks.paint(theme.dock);
  }

  set(docks: readonly Dock[],
      heightAt: (x: number, y: number, level: number) => number): void {
    this.marks.set(docks, ({ x, y, level }) => heightAt(x, y, level));
  }
}
