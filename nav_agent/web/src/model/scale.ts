// The scale bar: a round length that is easily seen.

const LENGTHS_M: readonly number[] = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50];

export interface ScaleBar {
  pixels: number;
  text: string;
}

// The longest round length of at most `most` pixels, else the shortest one.
export function scaleBar(pixelsPerMetre: number, most: number): ScaleBar {
  const fitting = LENGTHS_M.filter((metres) => metres * pixelsPerMetre <= most);
  const metres = fitting.at(-1) ?? LENGTHS_M[0];
  return {
    pixels: Math.round(metres * pixelsPerMetre),
    text: metres < 1 ? `${Math.round(100 * metres)} cm` : `${metres} m`,
  };
}
