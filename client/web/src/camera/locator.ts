// The camera's newest picture is located, again and again, while it runs.

import { gravityInCamera, type LocalizeAnswer, type LocalizeQuery,
  type Pinhole, type TimedQuery, type TreelineClient, type TreelineError } from
  '@treeline/client';

import { answeredPinhole, guessedPinhole, statedCamera } from
  '../model/camera_guess.js';
import type { LocatedPicture } from '../model/pin.js';
import type { Picture, PictureSource } from './device_camera.js';

/** What became of one picture. */
export type Located = {
  readonly picture: Picture;
  /** As it was stated with the picture. */
  readonly stated: Pinhole;
} & ({ readonly answer: LocalizeAnswer } | { readonly error: TreelineError });

export interface LocatorOptions {
  readonly scene: string;
  /** Asked before each picture. */
  readonly fieldOfViewDeg: () => number;
  readonly onLocated: (located: Located) => void;
}

const TIMEOUT_MS = 10_000;
// After a failure: the server may be busy.
const PAUSE_AFTER_ERROR_MS = 1000;
// Of pictures. One is on its way at a time, so most wait for the answer.
const MIN_INTERVAL_MS = 200;

const pause = (ms: number, signal: AbortSignal) =>
  new Promise<void>((resolve) => {
    const timer = setTimeout(resolve, ms);
    signal.addEventListener('abort', () => {
      clearTimeout(timer);
      resolve();
    }, { once: true });
  });

/** The camera of the answer's pose, with what supports it. */
export function locatedPictureOf(located: Located): LocatedPicture | null {
  if (!('answer' in located) || !located.answer.localized) return null;
  const { answer, stated } = located;
  return {
    camera: answeredPinhole(stated, answer),
    worldFromCamera: answer.worldFromCamera,
    correspondences: answer.correspondences,
  };
}

// Which way is up: by the device's tracking, else as the page is held.
const upOf = ({ tracked }: Picture): Partial<LocalizeQuery> =>
  tracked === undefined ? { sideUp: 'top', sideUpIsGuess: true } :
    { gravityInCameraMps2: gravityInCamera(tracked.deviceFromCamera) };

/** Runs until `signal` says so. A failed picture ends nothing but itself. */
export async function locate(client: TreelineClient, camera: PictureSource,
    options: LocatorOptions, signal: AbortSignal): Promise<void> {
  const sent = new Map<number, { picture: Picture; stated: Pinhole }>();
  // A picture is taken when the answer before it is there: one that waited
  // would be old when it is sent.
  let isFree = (): void => {};
  async function* pictures(): AsyncGenerator<TimedQuery, void, void> {
    while (!signal.aborted) {
      const free = new Promise<void>((resolve) => { isFree = resolve; });
      const picture = await camera.picture();
      const { widthPx, heightPx, jpeg, captureTimeMs } = picture;
      const stated = picture.tracked?.camera ??
          guessedPinhole(options.fieldOfViewDeg(), widthPx, heightPx);
      sent.set(captureTimeMs, { picture, stated });
      yield { captureTimeMs, query: { scene: options.scene, color: jpeg,
        camera: statedCamera(stated), ...upOf(picture),
        wantsCorrespondences: true } };
      await Promise.all([free, pause(MIN_INTERVAL_MS, signal)]);
    }
  }
  const answers = client.localizeLatest(
      pictures(), { timeoutMs: TIMEOUT_MS, signal });
  for await (const timed of answers) {
    const entry = sent.get(timed.captureTimeMs)!;
    sent.clear();
    options.onLocated('answer' in timed ? { ...entry, answer: timed.answer } :
      { ...entry, error: timed.error });
    if ('error' in timed) {
      await pause(timed.error.retryAfterMs ?? PAUSE_AFTER_ERROR_MS, signal);
    }
    isFree();
  }
}
