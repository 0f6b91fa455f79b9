// Answers and failures in words, with what to do.

import { TreelineError, type DriftState, type LocalizeAnswer, type Scene } from
  '@treeline/client';

export type Tone = 'calm' | 'busy' | 'warn' | 'bad';

export interface Saying {
  readonly title: string;
  readonly text: string;
  readonly tone: Tone;
}

const REASONS: Readonly<Record<string, string>> = {
  TOO_FEW_SAMPLES: 'The picture shows too little. Hold the camera still, in ' +
    'good light.',
  TOO_FEW_INLIERS: 'Nothing here was recognised. Turn to things with edges ' +
    'and patterns that were there when the scene was recorded.',
  POORLY_CONSTRAINED: 'What was recognised fits several places. Step back, ' +
    'so that more is in view.',
  LOW_CONFIDENCE: 'A pose was found, but it is not sure enough. Move a ' +
    'little, or step back.',
  CONTRADICTS_PRIOR: 'The pose is not where the camera was expected.',
  CONTRADICTS_DEPTH: 'The depth does not fit this scene.',
  UNKNOWN_CAMERA: 'What is seen does not tell which lens this is. Step ' +
    'back, so that more is in view.',
};

const REASONS_OF_OTHERS: Readonly<Record<string, string>> = {
  TOO_FEW_SAMPLES: 'The picture showed too little.',
  TOO_FEW_INLIERS: 'Nothing of the scene was recognised.',
  POORLY_CONSTRAINED: 'What was recognised fitted several poses.',
  LOW_CONFIDENCE: 'A pose was found, but not sure enough.',
  CONTRADICTS_PRIOR: 'The pose was not where the client expected it.',
  CONTRADICTS_DEPTH: 'The depth did not fit the scene.',
  UNKNOWN_CAMERA: 'The client did not say what camera it has.',
  INVALID_REQUEST: 'The request was not valid.',
  CANCELLED: 'The client went away.',
  DEADLINE_EXCEEDED: 'It took longer than the client would wait.',
};

/** Of another client's query, as the server names it. */
export const reasonInWords = (reason: string): string =>
  REASONS_OF_OTHERS[reason] ?? `The server says ${reason}.`;

// Without tracking nothing moves the drawing between answers.
const LOCATED: Saying = { title: 'Located', tone: 'calm',
  text: 'The drawing belongs to the last picture sent and stands still until ' +
    'the next answer. Hold the camera still.' };

const IN_SPACE: Readonly<Record<DriftState, Saying>> = {
  searching: { title: 'Looking', tone: 'busy',
    text: 'Move slowly, and look at things that were recorded.' },
  tentative: { title: 'Nearly there', tone: 'busy',
    text: 'Found once. Move sideways: a second view makes it sure.' },
  locked: { title: 'Located', tone: 'calm',
    text: 'The device follows the drawing; answers correct it.' },
  lost: { title: 'Lost', tone: 'warn',
    text: 'Nothing has confirmed this place for long: the drawing may be ' +
      'wrong. Look at things that were recorded.' },
};

/** Of a device that tracks itself. */
export const sayingOfTracking = (state: DriftState): Saying => IN_SPACE[state];

/** Why there is no session in the space around the device. */
export const sayingOfSpace = (name: string): Saying => ({
  title: 'Not in space', tone: 'warn', text: name === 'NotAllowedError' ?
    'The browser was not allowed to use augmented reality. Allow it for this ' +
      'page and start again, or start the camera alone.' :
    `This device shows pages no camera in augmented reality (${name}). ` +
      'Start the camera alone.' });

export const sayingOfAnswer = (answer: LocalizeAnswer): Saying =>
  answer.localized ? LOCATED : {
    title: 'Not located', tone: 'warn',
    text: REASONS[answer.reason] ?? `The server says ${answer.reason}.`,
  };

const NO_ACCESS: Saying = { title: 'No access', tone: 'bad',
  text: 'The server wants a token. Enter one under Access.' };

const ERRORS: Readonly<Partial<Record<string, Saying>>> = {
  unauthenticated: NO_ACCESS,
  permission_denied: { title: 'No access', tone: 'bad',
    text: 'This token does not allow it. It needs the scope "localize".' },
  unavailable: { title: 'No answer', tone: 'warn',
    text: 'The server is busy or cannot be reached. The page keeps asking.' },
  deadline_exceeded: { title: 'No answer in time', tone: 'warn',
    text: 'The server or the network is slow. The page keeps asking.' },
  resource_exhausted: { title: 'Too many questions', tone: 'warn',
    text: 'The server limits how often one client may ask. The page keeps ' +
      'asking.' },
  not_found: { title: 'No such scene', tone: 'bad',
    text: 'The server no longer has this scene. Load the list again.' },
};

export function sayingOfError(error: unknown): Saying {
  if (!(error instanceof TreelineError)) {
    return { title: 'A fault of this page', tone: 'bad', text: String(error) };
  }
  if (error.reason === 'TOKEN_EXPIRED') {
    return { ...NO_ACCESS, text: 'The token has expired. Enter a new one.' };
  }
  return ERRORS[error.code] ??
      { title: 'Refused', tone: 'bad', text: error.message };
}

/** Why getUserMedia() gave no camera. `name`: of its DOMException. */
export function sayingOfCamera(name: string): Saying {
  const refused = { title: 'No camera', tone: 'bad' as const };
  switch (name) {
    case 'InsecureContext':
      return { ...refused, text: 'Browsers give a camera to pages over HTTPS ' +
        'only, or to pages of this machine (localhost). Open this page with ' +
        'https://, or see "AR in the browser" in Treeline\'s documentation.' };
    case 'NotAllowedError':
      return { ...refused, text: 'The browser was not allowed to use the ' +
        'camera. Allow it for this page (the sign beside the address, then ' +
        '"Permissions"), also in the settings of the system, and start ' +
        'again.' };
    case 'NotFoundError':
      return { ...refused, text: 'This device has no camera. Connect one and ' +
        'start again.' };
    case 'NotReadableError':
      return { ...refused, text: 'Another program uses the camera. Close it ' +
        'and start again.' };
    default:
      return { ...refused, text: `The browser gave no camera (${name}).` };
  }
}

/** Why a scene cannot answer a page; null: it can, as far as is known. */
export function whySceneCannotAnswer({ state, method, failure }: Scene):
    string | null {
  if (state === 'failed') return `cannot be loaded: ${failure}`;
  if (method === 'rgbd' || method === 'points-lines') {
    return 'needs depth, which a browser has not';
  }
  return null;
}
