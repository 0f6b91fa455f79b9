// The program treeline-agent with a simulated robot, for the page's tests.

import { spawn } from 'node:child_process';

const PAUSE_MS = 50;

export class Agent {
  // program: treeline-agent; page: the built page. Ready when it drives.
  static async start(program, page, args) {
    const agent = new Agent();
    agent.child = spawn(program, ['run', '--listen', '127.0.0.1:0',
      '--http-listen', '127.0.0.1:0', '--page-dir', page, ...args],
    { stdio: ['ignore', 'pipe', 'pipe'] });
    agent.log = '';
    agent.child.stderr.on('data', (data) => { agent.log += data; });
    agent.ended = new Promise((resolve) => {
      agent.child.once('exit', (code, signal) => resolve(signal ?? code));
    });
    let said = '';
    await new Promise((resolve, reject) => {
      agent.child.stdout.on('data', (data) => {
        said += data;
        agent.url = /page on (\S+)/.exec(said)?.[1];
        if (agent.url && said.includes('driving')) resolve();
      });
      agent.ended.then((how) =>
        reject(new Error(`treeline-agent ended with ${how}: ${agent.log}`)));
    });
    return agent;
  }

  async get(path) {
    const answer = await fetch(new URL(path, this.url));
    if (!answer.ok) throw new Error(`${path}: ${answer.status}`);
    return answer.json();
  }

  // The first state for which `holds` does.
  async stateWhere(holds) {
    for (;;) {
      const state = await this.get('api/state');
      if (holds(state)) return state;
      await new Promise((resolve) => { setTimeout(resolve, PAUSE_MS); });
    }
  }

  // The exit code after SIGTERM, or the signal that ended it.
  async stop() {
    this.child.kill('SIGTERM');
    return this.ended;
  }

  kill() {
    this.child.kill('SIGKILL');
  }
}
