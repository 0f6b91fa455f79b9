// Which pixels agreed with the answer, drawn over the picture.

import type { Correspondence } from '@treeline/client';

export const AGREED = '#7cf0bd';
export const DISAGREED = '#ff9d7a';
export const OUTLINE = 'rgb(0 0 0 / 65%)';
const RADIUS_PX = 2.5;

/** Shape tells the two apart too: a disc agreed, a cross did not. */
export function drawPoints(canvas: HTMLCanvasElement,
    correspondences: readonly Correspondence[], widthPx: number): void {
  const context = canvas.getContext('2d')!;
  context.clearRect(0, 0, canvas.width, canvas.height);
  const scale = canvas.width / widthPx;
  const radius = RADIUS_PX * window.devicePixelRatio;
  // What agreed lies above.
  for (const isInlier of [false, true]) {
    const path = new Path2D();
    for (const { xPx, yPx, inlier } of correspondences) {
      if (inlier !== isInlier) continue;
      const x = (xPx + 0.5) * scale;
      const y = (yPx + 0.5) * scale;
      if (inlier) {
        path.moveTo(x + radius, y);
        path.arc(x, y, radius, 0, 2 * Math.PI);
      } else {
        path.moveTo(x - radius, y - radius);
        path.lineTo(x + radius, y + radius);
        path.moveTo(x - radius, y + radius);
        path.lineTo(x + radius, y - radius);
      }
    }
    context.lineWidth = window.devicePixelRatio * (isInlier ? 1.5 : 3);
    context.strokeStyle = OUTLINE;
    context.stroke(path);
    if (isInlier) {
      context.fillStyle = AGREED;
      context.fill(path);
    } else {
      context.lineWidth = window.devicePixelRatio;
      context.strokeStyle = DISAGREED;
      context.stroke(path);
    }
  }
}
