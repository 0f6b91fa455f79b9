// Where else a robot in doubt may be: hollow marks, each with its share.

import {
  BufferGeometry, CanvasTexture, Group, LineBasicMaterial, LineLoop, Sprite,
  SpriteMaterial, Vector3,
} from 'three';

import type { PossiblePlace } from '../../api/types.js';
import type { Theme } from '../theme.js';

const RADIUS_M = 0.32;
const NOSE_M = 0.62;
const CORNERS = 32;
const LABEL_M = 0.7;

// A ring with a nose along x, not filled.
function outline(): BufferGeometry {
  const points = [new Vector3(NOSE_M, 0, 0)];
  for (let i = 1; i < CORNERS; ++i) {
    const angle = 2 * Math.PI * i / CORNERS;
    points.push(new Vector3(
        RADIUS_M * Math.cos(angle), RADIUS_M * Math.sin(angle), 0));
  }
  return new BufferGeometry().setFromPoints(points);
}

class Mark {
  readonly object = new Group();
  private readonly ring = new Group();
  readonly lines = new LineBasicMaterial({ depthTest: false });
  private readonly canvas = document.createElement('canvas');
  private readonly texture: CanvasTexture;
  private text = '';
  private colour = '';

  constructor(geometry: BufferGeometry) {
    this.canvas.width = 128;
    this.canvas.height = 64;
    this.texture = new CanvasTexture(this.canvas);
    const label = new Sprite(
        new SpriteMaterial({ map: this.texture, depthTest: false }));
    label.scale.set(2 * LABEL_M, LABEL_M, 1);
    label.position.set(0, 0.7, 0);
    this.ring.add(new LineLoop(geometry, this.lines));
    this.object.add(this.ring, label);
    this.object.renderOrder = 5;
  }

  show(place: PossiblePlace, colour: string): void {
    this.object.visible = true;
    this.object.position.set(place.x, place.y, place.height + 0.1);
    this.ring.rotation.z = place.yaw;
    this.lines.color.set(colour);
    const text = `${Math.round(100 * place.share)} %`;
    if (text === this.text && colour === this.colour) return;
    this.text = text;
    this.colour = colour;
    const context = this.canvas.getContext('2d');
    if (context === null) return;
    context.clearRect(0, 0, this.canvas.width, this.canvas.height);
    context.font = 'bold 40px sans-serif';
    context.textAlign = 'center';
    context.textBaseline = 'middle';
    context.fillStyle = colour;
    context.fillText(text, this.canvas.width / 2, this.canvas.height / 2);
    this.texture.needsUpdate = true;
  }
}

export class OtherPlacesLayer {
  readonly object = new Group();
  private readonly geometry = outline();
  private readonly marks: Mark[] = [];
  private colour = '#000000';
  private places: readonly PossiblePlace[] = [];

  paint(theme: Theme): void {
    this.colour = `#${theme.robot.toString(16).padStart(6, '0')}`;
    this.set(this.places);
  }

  set(places: readonly PossiblePlace[]): void {
    this.places = places;
    while (this.marks.length < places.length) {
      const mark = new Mark(this.geometry);
      this.marks.push(mark);
      this.object.add(mark.object);
    }
    this.marks.forEach((mark, i) => {
      const place = places[i];
      if (place === undefined) mark.object.visible = false;
      else mark.show(place, this.colour);
    });
  }
}
