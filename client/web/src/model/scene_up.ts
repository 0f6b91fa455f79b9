// Which way is up in a scene, and where its floor is. Worlds have the axes of
// their training poses: z need not be up.

import type { Scene } from '@treeline/client';

export const UP_AXES = ['+z', '-z', '+y', '-y', '+x', '-x'] as const;
export type UpAxis = typeof UP_AXES[number];

export const DEFAULT_UP: UpAxis = '+z';

export type Bounds = NonNullable<Scene['boundsInWorldM']>;

export const isUpAxis = (text: string): text is UpAxis =>
  (UP_AXES as readonly string[]).includes(text);

export const axisOf = (up: UpAxis): 'x' | 'y' | 'z' => up[1] as 'x' | 'y' | 'z';

/** Coordinate of the floor along that axis: the lower side of the scene. */
export const floorM = (bounds: Bounds, up: UpAxis): number =>
  (up[0] === '-' ? bounds.max : bounds.min)[axisOf(up)];
