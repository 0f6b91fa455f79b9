// A place and a heading from one drag on the map.

export interface Place {
  x: number;
  y: number;
}

// Shorter drags are clicks (pixels): the heading is the one there was.
export const CLICK_PIXELS = 10;

export function headingOf(
    from: Place, to: Place, pixels: number, otherwise: number): number {
  if (pixels < CLICK_PIXELS) return otherwise;
  const dx = to.x - from.x;
  const dy = to.y - from.y;
  if (Math.hypot(dx, dy) < 1e-6) return otherwise;
  return Math.atan2(dy, dx);
}

// Of a goal that is clicked: the way that leads there from the robot.
export function headingTowards(robot: Place | null, goal: Place): number {
  if (robot === null) return 0;
  const dx = goal.x - robot.x;
  const dy = goal.y - robot.y;
  return Math.hypot(dx, dy) < 1e-6 ? 0 : Math.atan2(dy, dx);
}

// From `from` to `to`, the shorter way around; `share` 0 to 1.
export function turnBetween(from: number, to: number, share: number): number {
  const turn = Math.atan2(Math.sin(to - from), Math.cos(to - from));
  return from + share * turn;
}
