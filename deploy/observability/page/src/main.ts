// The servers' dashboard, drawn from the Prometheus that serves this page, where
// there is no Grafana: its panels, the alerts, and who is watched.

import './common/report/report.css';
import './style.css';
import { el, setData, setText } from './common/dom.js';
import { filledExpression, parseDashboard, stepFor, type Dashboard } from
  './model/panels.js';
import type { Alert, Scraped } from './model/series.js';
import { PanelCard } from './panel_card.js';
import * as prometheus from './prometheus.js';

const RANGES: [string, number][] = [['15 minutes', 900], ['1 hour', 3600],
  ['6 hours', 21600], ['1 day', 86400], ['1 week', 604800]];
const EVERY_MS = 5_000;

class Page {
  private readonly range = el('select', { id: 'range', attributes:
    { 'aria-label': 'Time that is shown' } }, ...RANGES.map(([name, seconds]) =>
    el('option', { attributes: { value: String(seconds) } }, name)));
  private readonly state = el('p', { class: 'note', id: 'state', attributes:
    { role: 'status' } });
  private readonly alerts = el('ul', { class: 'alerts', id: 'alerts' });
  private readonly watched = el('ul', { class: 'watched', id: 'watched' });
  private readonly cards: PanelCard[];

  constructor(dashboard: Dashboard, place: HTMLElement) {
    this.cards = dashboard.panels.map((panel) => new PanelCard(panel));
    this.range.addEventListener('change', () => void this.refresh());
    place.replaceChildren(
        el('header', 'top', el('h1', {}, dashboard.title), this.range),
        this.state, this.watched, el('h2', {}, 'Alerts'), this.alerts,
        el('h2', {}, 'Servers'),
        el('div', 'panels', ...this.cards.map((each) => each.element)));
    document.title = dashboard.title;
  }

  async run(): Promise<never> {
    for (;;) {
      // A page that nobody looks at asks nothing.
      if (!document.hidden) await this.refresh();
      await new Promise((resume) => setTimeout(resume, EVERY_MS));
    }
  }

  private async refresh(): Promise<void> {
    try {
      const { scraped, scrapeS } = await prometheus.targets();
      this.showWatched(scraped);
      this.showAlerts(await prometheus.alerts());
      await Promise.all(this.cards.map((each) => this.draw(each, scrapeS)));
      setText(this.state, '');
      setData(document.body, 'shown', 'true');
    } catch (error) {
      setText(this.state, 'Prometheus does not answer; this is from before. ' +
        (error instanceof Error ? error.message : String(error)));
    }
  }

  private async draw(card: PanelCard, scrapeS: number): Promise<void> {
    const rangeS = Number(this.range.value);
    const stepS = stepFor(rangeS, scrapeS);
    const now = Date.now() / 1000;
    try {
      const courses = await Promise.all(card.panel.targets.map(
          ({ expr, legend }) => prometheus.course(
              filledExpression(expr, stepS, scrapeS), legend, now, rangeS,
              stepS)));
      card.show(courses.flat(), new Date(1000 * (now - rangeS)),
          new Date(1000 * now));
    } catch (error) {
      card.showError(error);
    }
  }

  private showWatched(scraped: Scraped[]): void {
    this.watched.replaceChildren(...scraped.map(({ job, instance, isUp,
      error }) => el('li', isUp ? 'good' : 'bad',
        `${job} ${instance} ${isUp ? 'answers' : `does not answer: ${error}`}`)));
  }

  private showAlerts(alerts: Alert[]): void {
    this.alerts.replaceChildren(...alerts.map((alert) =>
      el('li', { class: 'card alert', attributes:
        { 'data-state': alert.state } },
      el('b', {}, alert.summary === '' ? alert.name : alert.summary),
      el('span', 'note', `${alert.name}, ${alert.severity}, ${alert.state}`),
      el('span', {}, alert.advice))));
    if (alerts.length === 0) this.alerts.append(el('li', 'good', 'None.'));
  }
}

const place = document.getElementById('report') as HTMLElement;
const dashboard = parseDashboard(
    document.getElementById('report-data')?.textContent ?? '');
if (typeof dashboard === 'string') {
  place.replaceChildren(el('p', 'bad', dashboard));
} else {
  void new Page(dashboard, place).run();
}
