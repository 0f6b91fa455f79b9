// What treeline wrote for its own test, report_test.cc.

import fs from 'node:fs';
import { parseReport, type EvaluationReport, type Frame, type Method,
  type RecognitionReport } from './report_data.js';

function read(name: string): unknown {
  const report = parseReport(
      fs.readFileSync(`fixtures/${name}.json`, 'utf8'));
  if (typeof report === 'string') throw new Error(report);
  return report;
}

export const evaluationFixture = (): EvaluationReport =>
  read('evaluation') as EvaluationReport;
export const recognitionFixture = (): RecognitionReport =>
  read('recognition') as RecognitionReport;

export function firstMethod(): Method {
  return evaluationFixture().methods[0] as Method;
}

export function frameAt(method: Method, index: number): Frame {
  return method.per_frame[index] as Frame;
}
