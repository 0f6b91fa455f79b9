// The page of failed queries: what the camera saw, why it failed, and which
// trace it belongs to. For holders of a token with the scope "inspect".

import './common/page.css';
import './style.css';
import './scene.css';
import './failed.css';

import { button, card, el, setText } from './common/dom.js';
import { failedQueriesOf, whyNot, type FailedQuery } from
  './model/failed_queries.js';
import { Settings } from './model/settings.js';
import { reasonInWords } from './model/words.js';

// The page lies in ar/ of the server.
const BASE = new URL('../failed-queries', window.location.href).href;

class FailedPage {
  private readonly settings = new Settings(localStorage, sessionStorage);
  private readonly token = el('input', { id: 'token', attributes: {
    'type': 'password', 'autocomplete': 'off', 'spellcheck': 'false',
    'aria-label': 'Token of the server' } });
  private readonly note = el('p', { class: 'detail', id: 'note',
    attributes: { role: 'status' } });
  private readonly list = el('div', { class: 'queries', id: 'failed' });
  private readonly picture = el('img', { class: 'failed-picture', id: 'picture',
    attributes: { alt: '' } });
  private readonly caption = el('p', { class: 'detail', id: 'caption' },
      'Choose a query.');
  private readonly details = el('pre', { class: 'failed-details',
    id: 'details' });
  // Of what is shown; what belongs to another comes too late.
  private showing = new AbortController();

  constructor() {
    this.token.value = this.settings.token;
    this.token.addEventListener('keydown', (event) => {
      if (event.key === 'Enter') void this.load();
    });
    document.body.append(
        el('header', { class: 'head' }, el('span', { class: 'mark' }),
            el('h1', {}, 'Treeline failed queries'),
            el('nav', {}, el('a', { class: 'head-link',
              attributes: { href: './scene.html' } }, 'Scene'))),
        el('main', {}, el('section', { class: 'stage failed-stage', attributes:
          { 'aria-label': 'The query' } }, this.picture, this.caption,
        this.details),
        el('div', { class: 'side' }, card('Access', 'access-card',
            el('div', { class: 'row' }, this.token,
                button('Show', () => void this.load(), { id: 'use-token' })),
            el('p', { class: 'detail' }, 'A token with the scope inspect. ' +
              'It is kept until this window closes.')),
        card('Failed queries', 'failed-card', this.note, this.list))));
    void this.load();
  }

  private fetch(path: string, signal?: AbortSignal): Promise<Response> {
    const token = this.token.value.trim();
    return fetch(BASE + path, { headers: token === '' ? {} :
      { Authorization: `Bearer ${token}` }, ...(signal && { signal }) });
  }

  private async load(): Promise<void> {
    this.settings.keepToken(this.token.value.trim());
    this.list.replaceChildren();
    try {
      const answer = await this.fetch('');
      if (!answer.ok) {
        setText(this.note, whyNot(answer.status));
        return;
      }
      const queries = failedQueriesOf(await answer.json());
      setText(this.note, queries.length === 0 ? 'None is kept.' :
        `${queries.length}, the newest first.`);
      this.list.append(...queries.map((query) => this.rowOf(query)));
    } catch (error) {
      setText(this.note, `The server cannot be asked: ${String(error)}`);
    }
  }

  private rowOf(query: FailedQuery): HTMLElement {
    const when = new Date(query.timeUtc).toLocaleString([], { hour12: false });
    const row = button('', () => void this.show(query, row),
        { class: 'query', attributes: { 'aria-pressed': 'false' } });
    row.append(el('span', {}, `${when} ${query.scene}`),
        el('span', { class: 'detail' }, reasonInWords(query.reason)));
    return row;
  }

  private async show(query: FailedQuery, row: HTMLElement): Promise<void> {
    this.showing.abort();
    const { signal } = this.showing = new AbortController();
    for (const other of this.list.children) {
      other.setAttribute('aria-pressed', String(other === row));
    }
    setText(this.caption, query.traceId === '' ? reasonInWords(query.reason) :
      `${reasonInWords(query.reason)} Trace ${query.traceId}`);
    try {
      const name = `/${encodeURIComponent(query.name)}`;
      const [picture, details] = await Promise.all(
          [this.fetch(`${name}/picture`, signal), this.fetch(name, signal)]);
      const shown = picture.ok ? await picture.blob() : null;
      const text = details.ok ? await details.text() : whyNot(details.status);
      if (signal.aborted) return;
      URL.revokeObjectURL(this.picture.src);
      this.picture.src = shown === null ? '' : URL.createObjectURL(shown);
      this.picture.alt = shown === null ? 'The query has no picture.' :
        'What the camera saw';
      setText(this.details, text);
    } catch (error) {
      if (!signal.aborted) setText(this.details, String(error));
    }
  }
}

new FailedPage();
