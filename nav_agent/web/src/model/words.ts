// The robot's state in plain words.

import type { Battery, Fix, Goal, RobotState } from '../api/types.js';

export type Tone = 'calm' | 'busy' | 'warn' | 'bad';

export interface Saying {
  title: string;
  text: string;
  tone: Tone;
}

const MODES: Record<string, Saying> = {
  idle: { title: 'Ready', text: 'Waiting for a goal.', tone: 'calm' },
  planning: {
    title: 'Planning', text: 'Looking for a way to the goal.', tone: 'busy',
  },
  driving: { title: 'Driving', text: 'On the way to the goal.', tone: 'busy' },
  recovering: {
    title: 'Working around',
    text: 'Something is in the way; the robot tries to get past.',
    tone: 'warn',
  },
  lost: {
    title: 'Lost', text: 'The robot stands still and asks where it is.',
    tone: 'warn',
  },
  relocalizing: {
    title: 'Finding its place',
    text: 'It looks around and checks where it is.', tone: 'warn',
  },
  paused: {
    title: 'Paused', text: 'Resume to let it drive on.', tone: 'calm',
  },
  safe_stop: {
    title: 'Safe stop',
    text: 'A device is missing. The robot goes on when it is back.',
    tone: 'bad',
  },
  stopped: {
    title: 'Stopped', text: 'It stands until it is released.', tone: 'bad',
  },
  manual: { title: 'Driven by hand', text: '', tone: 'busy' },
  need_help: {
    title: 'Needs help',
    text: 'The robot could not find its place.', tone: 'bad',
  },
};

// Names such as "safe stop" and "SAFE_STOP" are the same.
function keyOf(name: string): string {
  return name.trim().toLowerCase().replace(/[\s-]+/g, '_');
}

export function plain(name: string): string {
  const words = name.trim().replace(/[_-]+/g, ' ').toLowerCase();
  return words.charAt(0).toUpperCase() + words.slice(1);
}

function sentence(text: string): string {
  if (text === '') return '';
  const begun = text.charAt(0).toUpperCase() + text.slice(1);
  return /[.!?…]$/.test(begun) ? begun : `${begun}.`;
}

export function isPaused(state: RobotState): boolean {
  return keyOf(state.mode) === 'paused';
}

export function sayState(state: RobotState): Saying {
  const { route } = state;
  if (route?.state === 'waiting' && keyOf(state.mode) === 'idle') {
    return { title: 'Waiting', tone: 'busy',
      text: `At a waypoint, for ${Math.ceil(route.wait - route.waited)} s.` };
  }
  const known = MODES[keyOf(state.mode)];
  const saying: Saying = known ??
      { title: plain(state.mode || 'unknown'), text: '', tone: 'calm' };
  const hasCause = state.cause !== '' && state.cause !== 'none';
  const text = sentence(state.causeText) ||
      (hasCause ? `${plain(state.cause)}.` : saying.text);
  return { ...saying, text };
}

export function isUnderWay(goal: Goal | null): goal is Goal {
  return goal !== null &&
      (goal.state === 'accepted' || goal.state === 'active');
}

const GOALS: Record<Goal['state'], { title: string; tone: Tone }> = {
  accepted: { title: 'Goal accepted', tone: 'busy' },
  active: { title: 'On the way', tone: 'busy' },
  succeeded: { title: 'Arrived', tone: 'calm' },
  failed: { title: 'Not reached', tone: 'bad' },
  cancelled: { title: 'Cancelled', tone: 'warn' },
  unknown: { title: 'Goal', tone: 'calm' },
};

// What a goal does that is not over, where the robot does not drive to it.
const WAITS: Record<string, string> = {
  planning: 'Looking for a way',
  lost: 'Waits until the robot knows its place',
  relocalizing: 'Waits until the robot knows its place',
  need_help: 'Waits until the robot knows its place',
  paused: 'Waits for Resume',
  safe_stop: 'Waits until the robot may drive',
  stopped: 'Waits until the robot may drive',
  manual: 'Waits for Resume',
};

// Whether it stopped because it does not know its place.
export function isSearching(state: RobotState): boolean {
  return ['lost', 'relocalizing', 'need_help'].includes(keyOf(state.mode));
}

// A pose that the robot itself does not believe is not shown as its place.
export function knowsPlace(state: RobotState): boolean {
  return state.pose !== null && keyOf(state.lost.state) !== 'lost' &&
      !isSearching(state);
}

// The goal in one line, with how far it is where that is known.
export function sayGoal(goal: Goal, state: RobotState): Saying {
  const { title, tone } = GOALS[goal.state];
  const isOver: boolean = !isUnderWay(goal);
  if (isOver) return { title: `${title}.`, tone, text: goal.why };
  const mode = keyOf(state.mode);
  const waits = WAITS[mode];
  const isFar = goal.toGo > 0 && mode !== 'planning' && !isSearching(state);
  return {
    title: (waits ?? title) + (isFar ? `: ${metres(goal.toGo)} to go` : '.'),
    tone: waits === undefined || mode === 'planning' ? tone : 'warn',
    text: goal.why,
  };
}

export function metres(value: number): string {
  return `${value.toFixed(Math.abs(value) < 10 ? 1 : 0)} m`;
}

export function percent(share: number): string {
  return `${Math.round(100 * Math.max(0, Math.min(1, share)))} %`;
}

// With a minus sign that is as wide as a plus; no zero is negative.
export function signed(value: number, digits: number): string {
  const text = Math.abs(value).toFixed(digits);
  return value < 0 && Number(text) !== 0 ? `\u2212${text}` : text;
}

export function degrees(angle: number): string {
  return `${signed((angle * 180) / Math.PI, 0)}°`;
}

// Seconds since the agent began, as m:ss or h:mm:ss.
export function clockOf(seconds: number): string {
  const all = Math.max(0, Math.floor(seconds));
  const two = (n: number): string => String(n).padStart(2, '0');
  const hours = Math.floor(all / 3600);
  const minutes = Math.floor(all / 60) % 60;
  return hours > 0 ? `${hours}:${two(minutes)}:${two(all % 60)}` :
      `${minutes}:${two(all % 60)}`;
}

const LOST_STATES: Record<string, string> = {
  localized: 'Localized',
  map_changed_here: 'Localized; things here have moved',
  people_nearby: 'Localized; people are nearby',
};

// From here on the robot is not sure, and from there on it hardly can be.
const UNSURE = 0.3;
const DOUBTFUL = 0.7;

export interface Doubt extends Saying {
  // Of a meter, in [0, 1].
  share: number;
}

// Whether the robot knows its place: title and meter never say the opposite of
// the text. The verdict lags behind its probability, on purpose, and a robot
// that looks for its place has none that could be judged.
export function sayDoubt(state: RobotState): Doubt {
  const { lost } = state;
  const verdict = keyOf(lost.state);
  const hasReason = lost.reason !== '' && lost.reason !== 'none';
  const because = hasReason ? `: ${lost.reason.replace(/_/g, ' ')}` : '';
  const says = (text: string, tone: Tone): Doubt => ({
    title: percent(lost.probability), text: text + because, tone,
    share: lost.probability,
  });
  if (verdict === 'lost' || isSearching(state)) {
    const text = keyOf(state.mode) === 'relocalizing' ?
      'Looks for its place' : 'Does not know its place';
    const doubt = says(text, 'bad');
    return lost.probability >= DOUBTFUL ? doubt :
      { ...doubt, title: 'Yes', share: 1 };
  }
  if (lost.probability >= UNSURE) {
    return says('Is not sure of its place',
        lost.probability >= DOUBTFUL ? 'bad' : 'warn');
  }
  if (state.pose?.inDoubt) {
    const count = state.pose.others.length;
    const places = count === 0 ? 'looks for places that are alike' :
      count === 1 ? 'one other place looks alike' :
        `${count} other places look alike`;
    return { ...says('', 'warn'), text: `In doubt: ${places}` };
  }
  return says(LOST_STATES[verdict] ?? plain(lost.state), 'calm');
}

// "76 %, 74.5 V, charges"; '' of one that tells nothing.
export function sayBattery(battery: Battery | null): string {
  if (battery === null) return '';
  return [
    ...battery.charge === null ? [] : [percent(battery.charge)],
    ...battery.volts > 0 ? [`${battery.volts.toFixed(1)} V`] : [],
    ...battery.charging ? ['charges'] : [],
  ].join(' · ');
}

// What the server said of the last picture, and what became of that.
export function sayFix(fix: Fix): string {
  if (!fix.localized) {
    return fix.reason === '' ? 'The server did not recognize the place' :
        `Not recognized: ${plain(fix.reason).toLowerCase()}`;
  }
  return fix.verdict === '' ? 'Recognized' : plain(fix.verdict);
}
