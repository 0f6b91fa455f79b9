// The sentences that a report begins with.

import { percent } from './format.js';
import { isNear } from './frames.js';
import { isEvaluated, type FailedMethod, type Method } from './report_data.js';

export function methodVerdict(method: Method): string {
  const sentences: string[] = [];
  if (method.scored === 0) {
    sentences.push(`${method.localized} of ${method.frames} frames were ` +
      'localized; the recording has no ground truth to score them by.');
  } else {
    const near = method.per_frame.filter(isNear).length;
    sentences.push(`${near} of ${method.scored} frames were placed within ` +
      '5 cm and 5°.');
    const unknown = method.frames - method.scored;
    if (unknown > 0) {
      sentences.push(`${unknown} more ${unknown === 1 ? 'has' : 'have'} no ` +
        'ground truth.');
    }
  }
  const lost = method.frames - method.localized - method.errors;
  if (lost === 0) {
    sentences.push('None was given up as not localized.');
  } else {
    sentences.push(`${lost === 1 ? 'One was' : `${lost} were`} given up as ` +
      'not localized.');
  }
  if (method.errors > 0) {
    sentences.push(`${method.errors} could not be read or used.`);
  }
  return sentences.join(' ');
}

// More frames within 5 cm, then more of them within 2 cm.
function merit(method: Method): number {
  return method.correct_5cm_5deg === null ? -1 :
    method.correct_5cm_5deg + 1e-6 * (method.correct_2cm_2deg ?? 0);
}

export function comparisonVerdict(methods: (Method | FailedMethod)[]): string {
  const usable = methods.filter(isEvaluated);
  const sentences = [
    `${methods.length} method${methods.length === 1 ? '' : 's'} side by side.`,
  ];
  let best: Method | null = null;
  for (const method of usable) {
    if (merit(method) < 0) continue;
    if (best === null || merit(method) > merit(best)) best = method;
  }
  if (best !== null) {
    sentences.push(`Most accurate: ${best.name}, with ` +
      `${percent(best.correct_5cm_5deg)} of ${best.scored} frames within ` +
      '5 cm and 5°.');
  }
  const failed = methods.length - usable.length;
  if (failed > 0) sentences.push(`${failed} could not be evaluated.`);
  return sentences.join(' ');
}
