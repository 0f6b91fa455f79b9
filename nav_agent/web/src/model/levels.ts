// Which level is shown, and where the map is cut open.

// Above tables, below what would hide the floor from the side.
export const DEFAULT_CUT_M = 1.0;
// The control's end: nothing is cut off.
export const NO_CUT_M = 3.2;

// `picked`: by a person; null: the robot's own level is followed.
export function shownLevel(
    picked: number | null, robotLevel: number | null, levels: number): number {
  const wanted = picked ?? robotLevel ?? 0;
  return Math.max(0, Math.min(levels - 1, wanted));
}

// The height at which the map is cut open (m).
export function cutHeight(
    cutAboveGround: number, typicalGround: number,
    robot: { level: number; height: number } | null, level: number): number {
  if (cutAboveGround >= NO_CUT_M) return Infinity;
  const ground = robot !== null && robot.level === level ?
      Math.max(robot.height, typicalGround) : typicalGround;
  return ground + cutAboveGround;
}
