// What may be done to a simulated robot and its world.

import type { RobotScene } from '../api/types.js';
import { plain } from '../model/words.js';
import { button, el, setShown } from '../common/dom.js';

export interface SimulationCommands {
  kidnapAnywhere(): void;
  kidnapTo(place: string): void;
  removeObstacle(name: string): void;
  fault(target: string, kind: string, seconds: number): void;
}

const FAULTS: readonly [label: string, target: string, kind: string][] = [
  ['Laser silent', 'laser', 'silent'],
  ['Laser frozen', 'laser', 'frozen'],
  ['Odometry silent', 'odometry', 'silent'],
  ['Base silent', 'base', 'silent'],
  ['Camera silent', 'camera', 'silent'],
  ['Camera dark', 'camera', 'dark'],
  ['Server dead', 'server', 'silent'],
];
const SECONDS: readonly number[] = [2, 5, 15, 60];

function select(label: string, id: string, options: [string, string][]):
    HTMLSelectElement {
  return el('select', { id, attributes: { 'aria-label': label } },
      ...options.map(([value, text]) =>
        el('option', { attributes: { value } }, text)));
}

export class SimulationPanel {
  readonly element: HTMLElement;
  private readonly places = select('Place to kidnap the robot to', 'place', []);
  private readonly placeRow: HTMLElement;
  private readonly list = el('ul', { class: 'obstacles' });
  private names = '';

  // tools: those on the map that only a simulation has.
  constructor(
      private readonly commands: SimulationCommands, tools: HTMLElement) {
    const fault = select('Fault', 'fault',
        FAULTS.map(([label], i) => [String(i), label]));
    const seconds = select('For how long', 'fault-seconds',
        SECONDS.map((n) => [String(n), `${n} s`]));
    seconds.value = '5';
    this.placeRow = el('div', { class: 'row' }, this.places,
        button('Kidnap there', () => commands.kidnapTo(this.places.value),
            { id: 'kidnap-place' }));
    this.element = el('details', { class: 'card', id: 'simulation' },
        el('summary', {}, 'Simulation tools'),
        el('div', { class: 'needs-link' },
        el('p', { class: 'detail' },
            'Kidnap the robot to a place that it is not told, put a box in ' +
            'its way, or break a device.'),
        tools,
        el('div', { class: 'row' },
            button('Kidnap anywhere', () => commands.kidnapAnywhere(),
                { id: 'kidnap-anywhere', class: 'wide' })),
        this.placeRow,
        el('div', { class: 'row' }, fault, seconds,
            button('Break it', () => {
              const [, target, kind] = FAULTS[Number(fault.value)];
              commands.fault(target, kind, Number(seconds.value));
            }, { id: 'fault-start' })),
        this.list));
  }

  setPlaces(places: string[]): void {
    this.places.replaceChildren(...places.map((place) =>
      el('option', { attributes: { value: place } }, plain(place))));
    setShown(this.placeRow, places.length > 0);
  }

  update({ obstacles }: RobotScene): void {
    const names = obstacles.map(({ name }) => name).join('\n');
    if (names === this.names) return;
    this.names = names;
    this.list.replaceChildren(...obstacles.map(({ name, x, y }) =>
      el('li', {},
          el('span', {}, plain(name)),
          el('span', { class: 'detail' },
              `at ${x.toFixed(1)}, ${y.toFixed(1)}`),
          button('Remove', () => this.commands.removeObstacle(name), {
            class: 'small',
            attributes: { 'aria-label': `Remove ${plain(name)}` },
          }))));
  }
}
