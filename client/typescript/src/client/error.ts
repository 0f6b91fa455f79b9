// Why a call has no answer.

import { Code, ConnectError } from '@connectrpc/connect';

import { ErrorInfoSchema, RetryInfoSchema } from '../gen/google/rpc/status_pb.js';

/** Status codes, as the Connect protocol writes them. */
export type ErrorCode = 'canceled' | 'unknown' | 'invalid_argument' |
  'deadline_exceeded' | 'not_found' | 'already_exists' | 'permission_denied' |
  'resource_exhausted' | 'failed_precondition' | 'aborted' | 'out_of_range' |
  'unimplemented' | 'internal' | 'unavailable' | 'data_loss' |
  'unauthenticated';

/**
 * "Not localized" is no error: it is an answer. `reason` is stable, for
 * programs: docs/reference/service.md has the table. It is empty where no
 * server said anything.
 */
export class TreelineError extends Error {
  override readonly name = 'TreelineError';

  constructor(
      readonly code: ErrorCode,
      message: string,
      readonly reason = '',
      readonly metadata: Readonly<Record<string, string>> = {},
      /** When the server wants to be asked again, from now. */
      readonly retryAfterMs: number | null = null,
      options?: ErrorOptions) {
    super(message, options);
  }
}

// "invalid_argument" of InvalidArgument.
const nameOf = (code: Code): ErrorCode =>
  Code[code].replace(/(?!^)[A-Z]/g, '_$&').toLowerCase() as ErrorCode;

// RetryInfo is exact; Retry-After has whole seconds.
function retryAfterMsOf(error: ConnectError): number | null {
  for (const { retryDelay } of error.findDetails(RetryInfoSchema)) {
    if (retryDelay === undefined) continue;
    return Number(retryDelay.seconds) * 1000 + retryDelay.nanos / 1e6;
  }
  const header = error.metadata.get('Retry-After');
  return header !== null && /^\d+$/.test(header) ? Number(header) * 1000 : null;
}

/** The error of a call. `server` is the base URL that was asked. */
export function treelineErrorOf(error: unknown, server: string): TreelineError {
  if (error instanceof TreelineError) return error;
  const connect = ConnectError.from(error);
  // fetch fails with a TypeError: no connection, or it broke.
  if (connect.cause instanceof TypeError) {
    return new TreelineError('unavailable',
        `${server} cannot be reached: ${connect.cause.message}`, '', {}, null,
        { cause: error });
  }
  const [info] = connect.findDetails(ErrorInfoSchema);
  return new TreelineError(nameOf(connect.code), connect.rawMessage,
      info?.reason ?? '', info?.metadata ?? {}, retryAfterMsOf(connect),
      { cause: error });
}
