// Numbers for people.

import type { Maybe } from './report_data.js';

export const DASH = '–';

// With so many digits after the point; a dash if there is no number.
export function fixed(value: Maybe | undefined, digits: number): string {
  return value === null || value === undefined || !Number.isFinite(value) ?
    DASH : value.toFixed(digits);
}

// "98.9 %" of a share. Only all is 100 %, and only none is 0 %: one lost frame
// in a thousand is not none.
export function percent(share: Maybe | undefined): string {
  if (share === null || share === undefined) return DASH;
  if (share === 0 || share === 1) return `${(100 * share).toFixed(0)} %`;
  return `${Math.min(99.9, Math.max(0.1, 100 * share)).toFixed(1)} %`;
}

// Metres as centimetres.
export function cm(value_m: Maybe | undefined, digits: number): string {
  return value_m === null || value_m === undefined ? DASH :
    fixed(100 * value_m, digits);
}

// "34.2 MB", in powers of ten.
export function bytes(count: number): string {
  const units = ['B', 'kB', 'MB', 'GB', 'TB'];
  let value = count;
  let unit = 0;
  while (value >= 999.95 && unit + 1 < units.length) {
    value /= 1000;
    ++unit;
  }
  return `${unit === 0 ? value : value.toFixed(1)} ${units[unit]}`;
}

// "1 frame", "2 frames".
export function counted(count: number, one: string, many = `${one}s`): string {
  return `${count} ${count === 1 ? one : many}`;
}

// The last part of a recording's address: "7scenes-redkitchen"; with the part
// before it where it is short: "tum-fr1-rpy/test".
export function datasetName(uri: string): string {
  const name = uri.replace(/\/+$/, '');
  const parts = name.split(/[/:]/);
  const last = parts.pop() ?? '';
  const before = parts.pop();
  const separator = name[name.length - last.length - 1];
  return last.length < 6 && separator === '/' && before ?
    `${before}/${last}` : last;
}
