// What a server has kept of failed queries, as it tells of it.

/** One of the list; what the server does not know is ''. */
export interface FailedQuery {
  readonly name: string;
  readonly timeUtc: string;
  readonly reason: string;
  readonly scene: string;
  readonly status: string;
  readonly traceId: string;
}

const textOf = (value: unknown): string =>
  typeof value === 'string' ? value : '';

/** Of the answer of /failed-queries; throws a TypeError if it is none. */
export function failedQueriesOf(answer: unknown): readonly FailedQuery[] {
  const { queries } = answer as { queries?: unknown };
  if (!Array.isArray(queries)) throw new TypeError('not a list of queries');
  return queries.map((query: Record<string, unknown>) => ({
    name: textOf(query['name']),
    timeUtc: textOf(query['time_utc']),
    reason: textOf(query['reason']),
    scene: textOf(query['scene']),
    status: textOf(query['status']),
    traceId: textOf(query['trace_id']),
  }));
}

/** Why they cannot be seen, by the status of the answer. */
export function whyNot(status: number): string {
  switch (status) {
    case 401:
      return 'The server asks for a token with the scope inspect.';
    case 403:
      return 'This needs a token with the scope inspect, and a server with ' +
        'tokens.';
    case 404:
      return 'The server keeps no failed queries: --record DIR turns it on.';
    default:
      return `The server answers with ${status}.`;
  }
}
