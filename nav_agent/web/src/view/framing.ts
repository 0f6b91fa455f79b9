// Where to look from so that all of a box is in the picture.

import { Box3, Vector3, type PerspectiveCamera } from 'three';

// Of the picture's height and width, what is left free at its edges: tools are
// there.
export interface Margins {
  top: number;
  bottom: number;
  side: number;
}

// Rounds of nearing; each makes what is wrong several times smaller.
const ROUNDS = 12;

function cornersOf({ min, max }: Box3): Vector3[] {
  return [0, 1, 2, 3, 4, 5, 6, 7].map((i) => new Vector3(
      i & 1 ? max.x : min.x, i & 2 ? max.y : min.y, i & 4 ? max.z : min.z));
}

// Puts the camera on the far end of a line from the box's middle that leans by
// `tilt` (rad) from the vertical towards -y, so that the box fills the picture
// within its margins. Returns what it looks at then.
export function frameBox(camera: PerspectiveCamera, box: Box3, tilt: number,
                         margins: Margins): Vector3 {
  const corners = cornersOf(box);
  const target = box.getCenter(new Vector3());
  target.z = box.min.z;
  const away = new Vector3(0, -Math.sin(tilt), Math.cos(tilt));
  const tangent = Math.tan((camera.fov * Math.PI) / 360);
  let distance = box.getSize(new Vector3()).length() / tangent;
  for (let round = 0; round < ROUNDS; ++round) {
    camera.position.copy(target).addScaledVector(away, distance);
    camera.lookAt(target);
    camera.updateMatrixWorld();
    const seen = new Box3().setFromPoints(
        corners.map((corner) => corner.clone().project(camera)));
    const size = seen.getSize(new Vector3());
    const middle = seen.getCenter(new Vector3());
    const share = Math.max(
        size.x / (2 - 4 * margins.side),
        size.y / (2 - 2 * margins.top - 2 * margins.bottom));
    // Where the middle of what is seen belongs.
    const wanted = margins.bottom - margins.top;
    target.x += middle.x * distance * tangent * camera.aspect;
    target.y += ((middle.y - wanted) * distance * tangent) / Math.cos(tilt);
    distance *= share;
  }
  camera.position.copy(target).addScaledVector(away, distance);
  return target;
}
