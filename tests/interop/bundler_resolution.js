// Lets Node import modules that were written for bundlers, as
// @oarc/gpp-access is: './request' for './request/index.js', and './Sensor' for
// './Sensor.js'. Use: node --import ./bundler_resolution.js
import { register } from 'node:module';

const hooks = `
const endings = ['', '/index.js', '.js'];
export async function resolve(specifier, context, next) {
  let failure;
  for (const ending of specifier.startsWith('.') ? endings : ['']) {
    try {
      return await next(specifier + ending, context);
    } catch (error) {
      failure = failure ?? error;
    }
  }
  throw failure;
}`;

register(`data:text/javascript,${encodeURIComponent(hooks)}`);
