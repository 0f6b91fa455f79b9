// How often to draw where drawing is slow: software that draws, or an old
// telephone.

// A picture that is there within this time costs nothing worth sparing (ms).
const QUICK_MS = 50;
const LONGEST_REST_MS = 1000;

// Of a picture that took so long: for how long none is drawn after it. So two
// thirds of the time are left to other work.
export function restAfter(tookMs: number): number {
  return tookMs <= QUICK_MS ? 0 : Math.min(LONGEST_REST_MS, 2 * tookMs);
}
