// Over the map: levels, layers, ways to look, and tools.

import { LAYERS, type Angle, type LayerName } from '../view/map_view.js';
import { DEFAULT_CUT_M, NO_CUT_M } from '../model/levels.js';
import { button, el, setShown, setText } from '../common/dom.js';
import { MapHelp } from './map_help.js';

export type Tool = 'look' | 'goal' | 'pose' | 'zone' | 'route' |
  'dock' | 'kidnap' | 'obstacle';

export interface MapCommands {
  level(picked: number | null): void;
  layer(name: LayerName, isShown: boolean): void;
  cut(aboveGround: number): void;
  look(angle: Angle): void;
  follow(isOn: boolean): void;
  tool(tool: Tool): void;
}

const LAYER_LABELS: Record<LayerName, string> = {
  octomap: 'OctoMap', ground: 'Traversable map', zones: 'Zones',
  costmap: 'Local costmap',
  scan: 'Laser scan', particles: 'Particles', tree: 'Search tree',
  route: 'Route', docks: 'Docks', path: 'Path', bubbles: 'Bubbles', blockages: 'Blockages',
  truth: 'True pose (simulation)',
};

const TOOLS: readonly
    [tool: Tool, label: string, hint: string, key: string][] = [
      ['look', 'Look', '', ''],
      ['goal', 'Send goal',
        'Click where the robot shall go; drag to choose its heading.', 'g'],
      ['pose', 'Set pose',
        'Click where the robot stands; drag to choose its heading.', 'p'],
      // Its hints are beside what it needs.
      ['zone', 'Draw zone', '', 'z'],
      ['route', 'Draw route', '', 'r'],
      ['dock', 'Draw dock',
        'Click where the robot stands in its dock; drag to where it looks.',
        'k'],
      ['kidnap', 'Kidnap here',
        'Click where the robot shall be put without being told.', ''],
      ['obstacle', 'Add box', 'Click where a box shall stand.', ''],
    ];
const SIMULATION_TOOLS: readonly Tool[] = ['kidnap', 'obstacle'];

const STORE = 'treeline-layers';
// The search tree tells developers something, and covers the rest.
const HIDDEN_AT_FIRST: readonly LayerName[] = ['tree'];

function storedHidden(): Set<string> {
  try {
    const stored: unknown = JSON.parse(localStorage.getItem(STORE) ?? 'null');
    return new Set(
        Array.isArray(stored) ? stored.map(String) : HIDDEN_AT_FIRST);
  } catch {
    return new Set(HIDDEN_AT_FIRST);
  }
}

export class MapBar {
  readonly top: HTMLElement;
  readonly tools: HTMLElement;
  // Those of a simulation, apart from driving.
  readonly simulationTools: HTMLElement;
  readonly hint = el('p', {
    class: 'hint', id: 'hint', attributes: { 'aria-live': 'polite' },
  });
  readonly help = new MapHelp();
  private readonly layerBox: HTMLDetailsElement;
  private readonly level = el('select', {
    id: 'level', attributes: { 'aria-label': 'Level' },
    on: { change: () => this.pickLevel() },
  });
  private readonly levelBox: HTMLElement;
  private readonly follow: HTMLButtonElement;
  private readonly toolButtons = new Map<Tool, HTMLButtonElement>();
  private readonly hidden = storedHidden();
  private readonly truthRow: HTMLElement[] = [];
  private tool: Tool = 'look';

  constructor(private readonly commands: MapCommands) {
    this.levelBox = el('label', { class: 'chip' },
        el('span', {}, 'Level'), this.level);
    this.follow = button('Follow', () => {
      const isOn = this.follow.getAttribute('aria-pressed') !== 'true';
      this.follow.setAttribute('aria-pressed', String(isOn));
      commands.follow(isOn);
    }, { class: 'chip', id: 'follow', attributes: {
      'aria-pressed': 'false', 'title': 'Keep the robot in the middle' } });
    this.layerBox = this.layers();
    this.top = el('div', { class: 'map-top' }, this.levelBox,
        el('span', { class: 'chips' },
            button('3D', () => commands.look('oblique'),
                { class: 'chip', id: 'view-3d' }),
            button('Top', () => commands.look('top'),
                { class: 'chip', id: 'view-top' }),
            this.follow),
        this.layerBox, this.help.element);
    this.tools = el('div', {
      class: 'tools needs-link',
      attributes: { 'role': 'toolbar', 'aria-label': 'Tools on the map' },
    });
    this.simulationTools = el('div', { class: 'row', attributes: {
      'role': 'group', 'aria-label': 'Tools on the map' } });
    for (const [tool, label] of TOOLS) {
      const entry = button(label, () => this.choose(tool), {
        class: 'tool', id: `tool-${tool}`,
        attributes: { 'aria-pressed': 'false', 'data-tool': tool },
      });
      this.toolButtons.set(tool, entry);
      const isSimulation = SIMULATION_TOOLS.includes(tool);
      (isSimulation ? this.simulationTools : this.tools).append(entry);
    }
    document.addEventListener('keydown', (event) => {
      if (event.key !== 'Escape') return;
      this.choose('look');
      for (const popup of popups) popup.open = false;
    });
    // They are in the same place.
    const popups = [this.layerBox, this.help.element];
    for (const popup of popups) {
      popup.addEventListener('toggle', () => {
        if (!popup.open) return;
        for (const other of popups) other.open = other === popup;
      });
    }
    this.choose('look');
  }

  // Whether the key does something here.
  press(key: string): boolean {
    const tool = TOOLS.find(([, , , its]) => its !== '' && its === key)?.[0];
    const open = key === 'l' ? this.layerBox :
      key === '?' ? this.help.element : null;
    if (tool !== undefined) this.pressTool(tool);
    else if (key === 'f') this.follow.click();
    else if (key === 't') this.commands.look('top');
    else if (key === 'd') this.commands.look('oblique');
    else if (open !== null) open.open = !open.open;
    else return false;
    return true;
  }

  // As far as it can be pressed with a mouse.
  private pressTool(tool: Tool): void {
    const entry = this.toolButtons.get(tool);
    if (entry && !entry.hidden && !entry.closest('[inert]')) entry.click();
  }

  private layers(): HTMLDetailsElement {
    const rows = LAYERS.map((name) => {
      const box = el('input', { attributes: {
        type: 'checkbox', name: `layer-${name}` } });
      box.checked = !this.hidden.has(name);
      box.addEventListener('change', () => {
        if (box.checked) this.hidden.delete(name);
        else this.hidden.add(name);
        try {
          localStorage.setItem(STORE, JSON.stringify([...this.hidden]));
        } catch {
          // A browser that stores nothing shows what it does at first.
        }
        this.commands.layer(name, box.checked);
      });
      const row = el('label',
          { class: 'check', attributes: { 'data-layer': name } }, box,
          el('span', { class: 'swatch', attributes: { 'aria-hidden': 'true' } }),
          LAYER_LABELS[name]);
      if (name === 'truth') this.truthRow.push(row);
      return row;
    });
    const cut = el('input', {
      id: 'cut',
      attributes: {
        'type': 'range', 'min': '0.2', 'max': String(NO_CUT_M), 'step': '0.1',
        'aria-label': 'Cut the map open above the ground' },
    });
    cut.value = String(DEFAULT_CUT_M);
    const value = el('span', { class: 'value' }, `${DEFAULT_CUT_M.toFixed(1)} m`);
    cut.addEventListener('input', () => {
      const height = Number(cut.value);
      setText(value, height >= NO_CUT_M ? 'off' : `${height.toFixed(1)} m`);
      this.commands.cut(height);
    });
    return el('details', { class: 'layers popup' },
        el('summary', { class: 'chip' }, 'Layers'),
        el('div', { class: 'popover' }, ...rows,
            el('div', { class: 'cut' }, el('span', {}, 'Cut open at'), cut,
                value)));
  }

  // Tells the map what was chosen before.
  applyLayers(): void {
    for (const name of LAYERS) {
      this.commands.layer(name, !this.hidden.has(name));
    }
  }

  setLevels(count: number, isSimulated: boolean): void {
    this.level.replaceChildren(
        el('option', { attributes: { value: '' } }, 'Follow robot'),
        ...Array.from({ length: count }, (_, i) =>
          el('option', { attributes: { value: String(i) } }, String(i))));
    setShown(this.levelBox, count > 1);
    for (const tool of SIMULATION_TOOLS) {
      const entry = this.toolButtons.get(tool);
      if (entry) setShown(entry, isSimulated);
    }
    this.help.setSimulated(isSimulated);
    for (const row of this.truthRow) setShown(row, isSimulated);
    if (!isSimulated && SIMULATION_TOOLS.includes(this.tool)) {
      this.choose('look');
    }
  }

  // Names the level that is followed.
  showLevel(level: number): void {
    const [auto] = this.level.options;
    if (auto) setText(auto, `Robot's (${level})`);
  }

  private pickLevel(): void {
    const { value } = this.level;
    this.commands.level(value === '' ? null : Number(value));
  }

  choose(tool: Tool): void {
    this.tool = tool;
    for (const [name, entry] of this.toolButtons) {
      entry.setAttribute('aria-pressed', String(name === tool));
    }
    const hint = TOOLS.find(([name]) => name === tool)?.[2] ?? '';
    setText(this.hint, hint === '' ? '' : `${hint} Esc: stop.`);
    setShown(this.hint, hint !== '');
    this.commands.tool(tool);
  }
}
