// Reads a request a line, in base64, and writes what OpenTelemetry's own code
// makes of it, as a line of JSON: ids in hexadecimal, whole numbers as text.
const readline = require('node:readline');
const root = require('@opentelemetry/otlp-transformer/build/src/generated/root');

const { ExportTraceServiceRequest } =
    root.opentelemetry.proto.collector.trace.v1;
const HEX = new Set(['traceId', 'spanId', 'parentSpanId']);

function plain(value, key) {
  if (value instanceof Uint8Array) {
    if (!HEX.has(key)) throw new Error(`bytes in ${key}`);
    return Buffer.from(value).toString('hex');
  }
  if (Array.isArray(value)) return value.map((item) => plain(item, key));
  if (typeof value === 'number' || typeof value !== 'object') return value;
  // A whole number of 64 bits.
  if ('low' in value && 'high' in value) {
    return String(BigInt.asIntN(64,
        BigInt(value.high >>> 0) << 32n | BigInt(value.low >>> 0)));
  }
  return Object.fromEntries(Object.keys(value).map(
      (name) => [name, plain(value[name], name)]));
}

readline.createInterface({ input: process.stdin }).on('line', (line) => {
  const bytes = Buffer.from(line, 'base64');
  console.log(JSON.stringify(
      plain(ExportTraceServiceRequest.decode(bytes), '')));
});
