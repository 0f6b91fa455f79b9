// Heights as colours: calm enough that what lies over them stands out, and
// lighter with height, so that it reads without colour, too.

export type Colour = [red: number, green: number, blue: number];

const STOPS: readonly Colour[] = [
  [70, 100, 132], [74, 124, 142], [92, 147, 142], [139, 175, 148],
  [187, 199, 158], [221, 214, 178],
];

// share: 0 the lowest, 1 the highest.
export function heightColour(share: number): Colour {
  const at = Math.max(0, Math.min(1, share)) * (STOPS.length - 1);
  const below = Math.min(STOPS.length - 2, Math.floor(at));
  const rest = at - below;
  return [0, 1, 2].map((i) => Math.round(
      STOPS[below][i] + rest * (STOPS[below + 1][i] - STOPS[below][i]),
  )) as Colour;
}

// More change where people and robots are. share: of the map's height.
export function heightShare(share: number): number {
  return Math.max(0, share) ** 0.7;
}

export function shade(colour: Colour, factor: number): Colour {
  return colour.map((part) => Math.round(part * factor)) as Colour;
}
