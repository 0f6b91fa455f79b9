// The distributed trace that calls belong to:
// https://www.w3.org/TR/trace-context

const TRACEPARENT =
    /^00-(?!0{32})[0-9a-f]{32}-(?!0{16})[0-9a-f]{16}-[0-9a-f]{2}$/;

/** Whether it is one of version 00. */
export const isTraceparent = (text: string): boolean => TRACEPARENT.test(text);

function randomHex(bytes: number): string {
  const drawn = globalThis.crypto.getRandomValues(new Uint8Array(bytes));
  return [...drawn].map((byte) => byte.toString(16).padStart(2, '0')).join('');
}

/**
 * Of a new trace, for programs that record no spans of their own.
 * sampled: whether the server is asked to record its.
 */
export function newTraceparent(sampled = true): string {
  for (;;) {
    const made = `00-${randomHex(16)}-${randomHex(8)}-${sampled ? '01' : '00'}`;
    // 0 is no id.
    if (isTraceparent(made)) return made;
  }
}
