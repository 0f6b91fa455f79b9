// Docks on the ground: where the robot stands in them.

import { Group } from 'three';

import type { Dock } from '../../api/types.js';
import type { Theme } from '../theme.js';
import { PoseMark } from './mark_layers.js';

const MARK_SCALE = 0.6;

export class DockLayer {
  readonly object = new Group();
  private marks: PoseMark[] = [];
  private colour = 0;

  paint(theme: Theme): void {
    this.colour = theme.dock;
    for (const mark of this.marks) mark.material.color.set(this.colour);
  }

  set(docks: readonly Dock[],
      heightAt: (x: number, y: number, level: number) => number): void {
    while (this.marks.length < docks.length) {
      const mark = new PoseMark();
      mark.material.color.set(this.colour);
      mark.object.scale.setScalar(MARK_SCALE);
      this.marks.push(mark);
      this.object.add(mark.object);
    }
    this.marks.forEach((mark, i) => {
      const at = docks[i];
      if (at === undefined) mark.hide();
      else mark.show(at.x, at.y, heightAt(at.x, at.y, at.level), at.yaw);
    });
  }
}
