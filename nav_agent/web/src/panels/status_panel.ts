// What the robot does, why not, and what to do about it.

import type { RobotState } from '../api/types.js';
import {
  degrees, isPaused, isUnderWay, knowsPlace, metres, sayBattery, sayDoubt, sayGoal,
  sayState, signed,
} from '../model/words.js';
import { sayDocking } from '../model/dock_words.js';
import { isRouteOpen, mayGoOn, sayRoute } from '../model/route_draft.js';
import { button, card, el, Meter, setData, setShown, setText } from '../common/dom.js';

export interface RobotCommands {
  pause(): void;
  resume(): void;
  cancel(): void;
  findYourself(): void;
  resumeRoute(): void;
  cancelRoute(): void;
}

export class StatusPanel {
  readonly element: HTMLElement;
  private readonly title = el('p', { class: 'status-title', id: 'mode' });
  private readonly text = el('p', { class: 'status-text', id: 'cause' });
  private readonly advice = el('p', { class: 'advice', id: 'advice' });
  private readonly goalLine = el('p', { class: 'goal-line', id: 'goal' });
  private readonly goalMeter = new Meter('Part of the way that is done');
  private readonly goalWhy = el('p', { class: 'detail' });
  private readonly routeLine = el('p', { class: 'goal-line', id: 'route' });
  private readonly routeWhy = el('p', { class: 'detail', id: 'route-why' });
  private readonly goOn: HTMLButtonElement;
  private readonly endRoute: HTMLButtonElement;
  private readonly routeBox: HTMLElement;
  private readonly dockLine = el('p', { class: 'goal-line', id: 'docking' });
  private readonly dockWhy = el('p', { class: 'detail', id: 'docking-why' });
  private readonly dockBox =
      el('div', { class: 'goal' }, this.dockLine, this.dockWhy);
  private readonly pause: HTMLButtonElement;
  private readonly cancel: HTMLButtonElement;
  private readonly where: HTMLButtonElement;
  private readonly speed = el('dd');
  private readonly place = el('dd');
  private readonly doubt = el('dd');
  private readonly battery = el('dd', { id: 'battery' });
  private readonly batteryBox =
      el('div', {}, el('dt', {}, 'Battery'), this.battery);
  private isPaused = false;

  constructor(private readonly commands: RobotCommands) {
    this.pause = button('Pause', () => this.togglePause(),
        { class: 'wide', id: 'pause' });
    this.cancel = button('Cancel', () => commands.cancel(),
        { class: 'wide', id: 'cancel',
          attributes: { title: 'Give the goal up' } });
    this.where = button('Where am I?', () => commands.findYourself(),
        { class: 'wide', id: 'find-yourself',
          attributes: { title: 'The robot stops and asks the server' } });
    this.goOn = button('Go on', () => commands.resumeRoute(),
        { class: 'wide primary', id: 'route-resume',
          attributes: { title: 'Go on with the route' } });
    this.endRoute = button('End route', () => commands.cancelRoute(),
        { class: 'wide', id: 'route-cancel' });
    this.routeBox = el('div', { class: 'goal' }, this.routeLine, this.routeWhy,
        el('div', { class: 'row needs-link' }, this.goOn, this.endRoute));
    const live = el('div',
        { attributes: { 'aria-live': 'polite', 'aria-atomic': 'true' } },
        this.title, this.text, this.advice);
    this.element = card('Robot', 'status', live,
        el('div', { class: 'goal' }, this.goalLine, this.goalMeter.element,
            this.goalWhy),
        this.routeBox, this.dockBox,
        el('div', { class: 'buttons needs-link' }, this.pause, this.cancel, this.where),
        el('dl', { class: 'figures' },
            el('div', {}, el('dt', {}, 'Speed'), this.speed),
            el('div', {}, el('dt', {}, 'Place'), this.place),
            el('div', {}, el('dt', {}, 'Sure to'), this.doubt),
            this.batteryBox));
  }

  // As a click on the button does, if it can be clicked.
  pressPause(): void {
    if (!this.pause.closest('[inert]')) this.pause.click();
  }

  private togglePause(): void {
    if (this.isPaused) this.commands.resume();
    else this.commands.pause();
  }

  update(state: RobotState): void {
    const saying = sayState(state);
    setData(this.element, 'tone', saying.tone);
    setText(this.title, saying.title);
    setText(this.text, saying.text);
    const isCalm = state.cause === '' || state.cause === 'none';
    setText(this.advice, isCalm ? '' : state.advice);
    setShown(this.advice, !isCalm && state.advice !== '');
    this.updateGoal(state);
    this.updateRoute(state);
    this.updateDocking(state);
    this.isPaused = isPaused(state);
    setText(this.pause, this.isPaused ? 'Resume' : 'Pause');
    this.pause.classList.toggle('primary', this.isPaused);
    this.cancel.disabled =
        !isUnderWay(state.goal) && !isRouteOpen(state.route) &&
        state.docking?.outcome !== 'under_way';
    const { command } = state;
    const pose = knowsPlace(state) ? state.pose : null;
    setText(this.speed, `${signed(command.forward, 2)} m/s`);
    setText(this.place, pose === null ? 'unknown' :
        `${pose.x.toFixed(2)}, ${pose.y.toFixed(2)} m · ${degrees(pose.yaw)}`);
    const battery = sayBattery(state.battery);
    setText(this.battery, battery);
    setShown(this.batteryBox, battery !== '');
    setText(this.doubt, pose === null || pose.std === null ? '–' :
        (pose.std < 1 ? `${Math.round(100 * pose.std)} cm` :
          metres(pose.std)) +
        (pose.stdYaw === null ? '' : ` · ${degrees(pose.stdYaw)}`));
  }

  private updateRoute({ route, stop }: RobotState): void {
    setShown(this.routeBox, route !== null);
    if (route === null) return;
    const saying = sayRoute(route);
    setText(this.routeLine, saying.title);
    setData(this.routeLine, 'tone', saying.tone);
    setText(this.routeWhy, saying.text);
    setShown(this.routeWhy, saying.text !== '');
    setShown(this.goOn, mayGoOn(route));
    this.goOn.disabled = stop !== null;
    // One that is under way ends with Cancel.
    setShown(this.endRoute, mayGoOn(route));
  }

  private updateDocking({ docking }: RobotState): void {
    const saying = sayDocking(docking);
    setShown(this.dockBox, saying !== null);
    if (saying === null) return;
    setText(this.dockLine, saying.title);
    setData(this.dockLine, 'tone', saying.tone);
    setText(this.dockWhy, saying.text);
    setShown(this.dockWhy, saying.text !== '');
  }

  private updateGoal(state: RobotState): void {
    const { goal } = state;
    setShown(this.goalMeter.element, isUnderWay(goal));
    if (goal === null) {
      setText(this.goalLine, 'No goal yet.');
      setText(this.goalWhy, '');
      return;
    }
    const saying = sayGoal(goal, state);
    const all = goal.driven + goal.toGo;
    setText(this.goalLine, saying.title);
    setData(this.goalLine, 'tone', saying.tone);
    this.goalMeter.set(all > 0 ? goal.driven / all : 0, 'busy');
    // Of a goal that was reached the agent says itself how far it was.
    const parts = goal.state === 'succeeded' && saying.text !== '' ? [] :
        [`${metres(goal.driven)} driven`];
    if (goal.replans > 0) parts.push(goal.replans === 1 ?
        '1 new plan' : `${goal.replans} new plans`);
    if (goal.recoveries > 0) parts.push(`${goal.recoveries} recoveries`);
    setText(this.goalWhy,
        [saying.text, parts.join(' · ')].filter((part) => part).join(' — '));
  }
}

export class LostPanel {
  readonly element: HTMLElement;
  private readonly meter = new Meter('Probability that the robot is lost');
  private readonly value = el('span', { class: 'value', id: 'lost-value' });
  private readonly text = el('p', { class: 'detail' });

  constructor() {
    this.element = card('Is it lost?', 'lost',
        el('div', { class: 'row' }, this.meter.element, this.value),
        this.text);
  }

  update(state: RobotState): void {
    const doubt = sayDoubt(state);
    this.meter.set(doubt.share, doubt.tone);
    setText(this.value, doubt.title);
    setText(this.text, doubt.text);
  }
}
