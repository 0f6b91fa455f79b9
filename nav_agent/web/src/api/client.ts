// Commands to the agent, and what is fetched from it once.

import { decodeInfo } from './decode.js';
import type { AgentInfo, Pose } from './types.js';

// What the agent answered, or why there is no answer, for people.
export class ApiError extends Error {
  constructor(readonly code: string, message: string) {
    super(message);
    this.name = 'ApiError';
  }
}

export type Fetch = (url: string, init?: RequestInit) => Promise<Response>;

export class AgentClient {
  constructor(
      private readonly fetch: Fetch, private readonly timeoutMs = 8000) {}

  async info(): Promise<AgentInfo> {
    const response = await this.get('api/info');
    return decodeInfo(await jsonOf(response));
  }

  async bytes(path: string): Promise<ArrayBuffer> {
    return (await this.get(path)).arrayBuffer();
  }

  async picture(path: string): Promise<Blob> {
    return (await this.get(path)).blob();
  }

  async sendGoal(poses: Pose[]): Promise<void> {
    await this.post('api/goal', { poses });
  }

  async setPose(pose: Pose): Promise<void> {
    await this.post('api/initial-pose', pose);
  }

  cancel = (): Promise<void> => this.post('api/cancel', {});
  pause = (): Promise<void> => this.post('api/pause', {});
  resume = (): Promise<void> => this.post('api/resume', {});
  findYourself = (): Promise<void> => this.post('api/find-yourself', {});

  kidnapTo(target: Pose | { place: string } | Record<string, never>):
      Promise<void> {
    return this.post('api/sim/kidnap', target);
  }

  addObstacle(x: number, y: number, level: number, sizeM: number):
      Promise<void> {
    return this.post('api/sim/obstacle', { x, y, level, size_m: sizeM });
  }

  removeObstacle(name: string): Promise<void> {
    return this.post('api/sim/remove-obstacle', { name });
  }

  injectFault(target: string, kind: string, durationS: number): Promise<void> {
    return this.post(
        'api/sim/fault', { target, kind, duration_s: durationS });
  }

  private get(path: string): Promise<Response> {
    return this.ask(path, { cache: 'no-cache' });
  }

  private async post(path: string, body: object): Promise<void> {
    const response = await this.ask(path, {
      method: 'POST',
      // A page of another origin cannot send this header unasked.
      headers: { 'Content-Type': 'application/json', 'X-Treeline': '1' },
      body: JSON.stringify(body),
    });
    await response.text();
  }

  // A response with a good status, or an ApiError.
  private async ask(path: string, init: RequestInit): Promise<Response> {
    const abort = new AbortController();
    const timer = setTimeout(() => abort.abort(), this.timeoutMs);
    try {
      const response =
          await this.fetch(path, { ...init, signal: abort.signal });
      if (!response.ok) throw await errorOf(response);
      return response;
    } catch (error) {
      if (error instanceof ApiError) throw error;
      throw abort.signal.aborted ?
          new ApiError('timeout', 'The agent did not answer in time.') :
          new ApiError('unreachable', 'The agent cannot be reached.');
    } finally {
      clearTimeout(timer);
    }
  }
}

async function jsonOf(response: Response): Promise<unknown> {
  try {
    return await response.json();
  } catch {
    throw new ApiError('garbled', 'The agent\'s answer is not JSON.');
  }
}

// {"error":{"code","message"}}; anything else is told by its status.
async function errorOf(response: Response): Promise<ApiError> {
  const status = `The agent answered with status ${response.status}.`;
  try {
    const body = await response.json() as
        { error?: { code?: unknown; message?: unknown } };
    const { code, message } = body.error ?? {};
    return new ApiError(
        typeof code === 'string' ? code : `http_${response.status}`,
        typeof message === 'string' && message !== '' ? message : status);
  } catch {
    return new ApiError(`http_${response.status}`, status);
  }
}
