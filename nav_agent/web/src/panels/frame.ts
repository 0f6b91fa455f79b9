// Around everything: head line, lost connection, and short messages.

import type { AgentInfo } from '../api/types.js';
import type { Link } from '../api/stream.js';
import { el, setData, setShown, setText } from '../common/dom.js';

export class HeadLine {
  readonly element: HTMLElement;
  private readonly map = el('span', { class: 'map-name' });
  private readonly simulated = el('span', { class: 'tag', id: 'world' });
  private readonly server = el('span', { class: 'server detail' });
  private readonly link = el('span', {
    class: 'link', id: 'link', attributes: { role: 'status' },
  }, 'Connecting');

  constructor(stop: HTMLElement) {
    const mark = el('span', {
      class: 'mark', attributes: { 'aria-hidden': 'true' } });
    this.element = el('header', { class: 'head' }, mark,
        el('h1', {}, 'Treeline'), this.map, this.simulated, this.server,
        this.link, stop);
  }

  setInfo(info: AgentInfo): void {
    setText(this.map, info.mapName);
    setShown(this.simulated, info.simulated);
    setText(this.simulated, `Simulated: ${info.world}`);
    setText(this.server,
        info.server === '' ? 'No server' : `Server ${info.server}`);
    this.element.title = `treeline-agent ${info.version}`;
    document.title = info.mapName === '' ? 'Treeline robot' :
        `${info.mapName} – Treeline robot`;
  }

  setLink(link: Link): void {
    setData(this.link, 'link', link);
    setText(this.link, link === 'live' ? 'Live' :
      link === 'lost' ? 'No connection' : 'Connecting');
  }
}

// Says at once that what is shown is old.
export class LostBanner {
  readonly element: HTMLElement;
  private readonly text = el('span');
  private lostAt = 0;
  private timer = 0;

  constructor(retry: () => void) {
    this.element = el('div', {
      class: 'banner', id: 'banner', attributes: { role: 'alert' } },
    this.text,
    el('button', {
      class: 'small', attributes: { type: 'button' }, on: { click: retry },
    }, 'Try now'));
    this.element.hidden = true;
  }

  // lastHeard: when the shown state came (ms); 0: never.
  setLink(link: Link, lastHeard: number): void {
    document.body.classList.toggle('is-stale', link !== 'live');
    window.clearInterval(this.timer);
    setShown(this.element, link === 'lost');
    if (link !== 'lost') return;
    this.lostAt = lastHeard;
    this.say();
    this.timer = window.setInterval(() => this.say(), 1000);
  }

  private say(): void {
    const age = Math.round((Date.now() - this.lostAt) / 1000);
    setText(this.text, this.lostAt === 0 ?
        'The robot\'s program cannot be reached. Trying again …' :
        `Connection lost: what you see is ${age} s old. The robot looks after ` +
        'itself. Trying again …');
  }
}

const TOAST_MS = 6000;

export class Toasts {
  readonly element = el('div', {
    class: 'toasts', id: 'toasts',
    attributes: { 'role': 'status', 'aria-live': 'polite' },
  });

  say(text: string, tone: 'calm' | 'bad'): void {
    const toast = el('p', {
      class: 'toast', attributes: { 'data-tone': tone } }, text);
    this.element.append(toast);
    while (this.element.children.length > 3) {
      this.element.firstElementChild?.remove();
    }
    window.setTimeout(() => toast.remove(), TOAST_MS);
  }
}
