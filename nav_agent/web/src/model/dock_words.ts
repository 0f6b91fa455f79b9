// Docks, docking and charging in words.

import type { Dock, Docking } from '../api/types.js';
import type { Saying, Tone } from './words.js';

// What the agent takes.
export const MOST_DOCK_NAME_BYTES = 64;

// "Dock 2": the first such name that is free.
export function freeDockName(docks: readonly Dock[]): string {
  const names = new Set(docks.map(({ name }) => name));
  for (let i = 1; ; ++i) {
    if (!names.has(`Dock ${i}`)) return `Dock ${i}`;
  }
}

// What a dock says, for a list.
export const dockDetail = (dock: Dock, levels: number): string => [
  dock.isBackward ? 'backwards' : 'forwards',
  ...levels > 1 ? [`level ${dock.level}`] : [],
].join(', ');

const STATES: Record<string, [words: string, tone: Tone]> = {
  'to_staging': ['drives to', 'busy'],
  'driving_in': ['drives into', 'busy'],
  'touching': ['looks for the contact of', 'busy'],
  'backing_out': ['backs out of', 'warn'],
  'docked': ['stands in', 'calm'],
  'driving_out': ['drives out of', 'busy'],
};
const CHARGES: Record<string, [words: string, tone: Tone]> = {
  low: ['Battery low', 'warn'],
  going: ['Goes to charge', 'busy'],
  charging: ['Charges', 'calm'],
};

// null: there is nothing to say of it.
export function sayDocking(docking: Docking | null): Saying | null {
  if (docking === null) return null;
  const state = STATES[docking.state];
  const charge = CHARGES[docking.charge];
  const hasFailed = docking.outcome === 'failed' && state === undefined;
  const titles = [
    ...charge === undefined ? [] : [charge[0]],
    ...state === undefined ? [] : [`${state[0]} ${docking.dock}`],
    ...hasFailed ? ['docking failed'] : [],
  ];
  const [first, ...rest] = titles;
  if (first === undefined) return null;
  const texts = [
    ...docking.chargeWhy === '' ? [] : [docking.chargeWhy],
    ...hasFailed && docking.why !== docking.chargeWhy ? [docking.why] : [],
    ...docking.failedTries > 0 && docking.outcome === 'under_way' ?
      [`${docking.failedTries} of 3 tries in vain`] : [],
  ];
  return {
    title: [first.charAt(0).toUpperCase() + first.slice(1), ...rest].join(', '),
    text: texts.join(' — '),
    tone: hasFailed ? 'bad' : charge?.[1] ?? state?.[1] ?? 'calm',
  };
}
