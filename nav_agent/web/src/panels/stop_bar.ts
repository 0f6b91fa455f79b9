// The stop, in reach at every size of the page, and its release.

import type { RobotState } from '../api/types.js';
import { button, el, setShown, setText } from '../common/dom.js';

export interface StopCommands {
  stop(): void;
  release(): void;
}

export class StopBar {
  // In the head line; it works without a live connection, too: the call may get
  // through where the stream does not.
  readonly button: HTMLButtonElement;
  readonly banner: HTMLElement;
  private readonly why = el('span');

  constructor(commands: StopCommands) {
    this.button = button('Stop', () => commands.stop(), {
      class: 'stop', id: 'stop', attributes: {
        title: 'The robot stands until it is released (X)' } });
    this.banner = el('div', {
      class: 'banner stopped', id: 'stopped', attributes: { role: 'alert' } },
    this.why,
    button('Release', () => commands.release(), {
      class: 'small', id: 'release', attributes: {
        title: 'The robot may be driven again; nothing moves by that' } }));
    this.banner.hidden = true;
  }

  update({ stop }: RobotState): void {
    setShown(this.banner, stop !== null);
    if (stop !== null) {
      setText(this.why, `Stopped until it is released: ${stop.why}.`);
    }
  }
}
