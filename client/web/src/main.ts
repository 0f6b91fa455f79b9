// The AR page: a camera, the server's answers, and notes in the world.

import './common/page.css';
import './style.css';
import './ar.css';

import { TreelineClient, TreelineError, type DriftState, type Scene } from
  '@treeline/client';

import { CameraRefused, DeviceCamera } from './camera/device_camera.js';
import { locate, locatedPictureOf, type Located } from './camera/locator.js';
import { hasSpace, requestSpace } from './camera/space_camera.js';
import { SpaceRun } from './camera/space_run.js';
import { correctedFieldOfViewDeg } from './model/camera_guess.js';
import { loadNotes, saveNotes, type Note } from './model/notes.js';
import { pinAt, type LocatedPicture, type PixelPoint } from './model/pin.js';
import { Settings } from './model/settings.js';
import { sayingOfAnswer, sayingOfCamera, sayingOfError, sayingOfSpace,
  sayingOfTracking, whySceneCannotAnswer, type Saying } from
  './model/words.js';
import { el, setShown } from './common/dom.js';
import { NoteDialog, NotesCard } from './panels/notes_card.js';
import { SceneCard } from './panels/scene_card.js';
import { StatusCard } from './panels/status_card.js';
import { ViewCard } from './panels/view_card.js';
import { Stage } from './view/stage.js';

const READY: Saying = { title: 'Ready', tone: 'calm',
  text: 'Choose a scene and start the camera.' };
const NO_SCENES: Saying = { title: 'No scene', tone: 'warn',
  text: 'The server has no scene that a camera without depth can use.' };
const LOOKING: Saying = { title: 'Looking', tone: 'busy',
  text: 'The first picture is on its way. Hold the camera still.' };
const TAKEN: Saying = { title: 'Camera gone', tone: 'bad',
  text: 'The camera was taken away. Start it again.' };

// More would hide the picture.
const MAP_POINTS = 20_000;

class ArPage {
  private readonly settings = new Settings(localStorage, sessionStorage);
  private readonly client = new TreelineClient({
    // The page lies in ar/ of the server.
    servers: new URL('..', window.location.href).href,
    token: () => this.settings.token,
  });
  private readonly status = new StatusCard();
  private readonly dialog = new NoteDialog();
  private readonly sceneCard = new SceneCard({
    onScene: () => this.chooseScene(),
    onStart: () => void this.start(),
    onStartInSpace: () => void this.startInSpace(),
    onStop: () => this.stop(READY),
    onToken: (token) => void this.useToken(token),
  }, this.settings.token);
  private readonly viewCard = new ViewCard({
    onLayer: (layer, isShown) => {
      this.stage.show(layer, isShown);
      if (isShown && (layer === 'cloud' || layer === 'keyframes')) {
        void this.loadMap();
      }
    },
    onFieldOfView: (fieldOfViewDeg) => this.keepFieldOfView(fieldOfViewDeg),
    onUp: (up) => {
      this.settings.keepUp(this.sceneCard.scene, up);
      this.showScene();
    },
  });
  private readonly notesCard = new NotesCard({
    onPin: () => this.pin(this.stage.crossPoint),
    onEdit: (note) => void this.edit(note),
  });
  private readonly empty = el('p', { class: 'empty' },
      'The camera is off. Nothing is sent before you start it.');
  private readonly stage = new Stage({
    onPoint: (at) => this.pin(at),
    onNote: (note) => void this.edit(note),
  }, this.empty);

  private readonly sceneLink = el('a', { class: 'head-link',
    id: 'scene-link', attributes: { href: 'scene.html' } }, 'Scene');

  private scenes: readonly Scene[] = [];
  // The scene whose map is drawn, or on its way.
  private mapped = '';
  private isMapDrawn = false;
  private answers = 0;
  private notes: Note[] = [];
  private camera: DeviceCamera | null = null;
  private space: SpaceRun | null = null;
  private running: AbortController | null = null;
  private fieldOfViewDeg = this.settings.fieldOfViewDeg('');
  private picture: LocatedPicture | null = null;
  private spaceState: DriftState | null = null;

  constructor() {
    document.body.append(
        el('header', { class: 'head' }, el('span', { class: 'mark' }),
            el('h1', {}, 'Treeline AR'),
            el('nav', {}, this.sceneLink)),
        el('main', {}, this.stage.element, el('div', { class: 'side' },
            this.sceneCard.element, this.status.element,
            this.notesCard.element, this.viewCard.element)),
        this.dialog.element);
    this.viewCard.setFieldOfView(this.fieldOfViewDeg);
    // Tests ask where things are drawn, and of which answer.
    Object.assign(window, { treeline: {
      shareOf: (x: number, y: number, z: number) =>
        this.stage.shareOf(x, y, z),
      answers: () => this.answers,
      hasMap: () => this.isMapDrawn,
      position: () => this.located?.worldFromCamera.translationM ?? null } });
  }

  async offerSpace(): Promise<void> {
    if (await hasSpace()) this.sceneCard.offerSpace();
  }

  async loadScenes(): Promise<void> {
    try {
      this.scenes = await this.client.scenes();
    } catch (error) {
      this.fail(error);
      return;
    }
    const asked = new URLSearchParams(window.location.search).get('scene');
    const able = this.scenes.filter(
        (scene) => whySceneCannotAnswer(scene) === null);
    const chosen = able.find(({ name }) => name === asked) ?? able[0];
    this.sceneCard.setScenes(this.scenes, chosen?.name ?? '');
    this.status.say(chosen === undefined ? NO_SCENES : READY);
    this.chooseScene();
  }

  private async useToken(token: string): Promise<void> {
    this.settings.keepToken(token);
    await this.loadScenes();
  }

  private fail(error: unknown): void {
    this.status.say(sayingOfError(error));
    if (error instanceof TreelineError && error.code === 'unauthenticated') {
      this.stop(sayingOfError(error));
      this.sceneCard.askForToken();
    }
  }

  private chooseScene(): void {
    if (this.running !== null) this.stop(READY);
    const { scene } = this.sceneCard;
    this.notes = loadNotes(localStorage, scene);
    this.sceneLink.href = `scene.html?scene=${encodeURIComponent(scene)}`;
    if (this.mapped !== '' && this.mapped !== scene) {
      this.stage.setMap(null);
      void this.loadMap();
    }
    this.notesCard.say('');
    this.showNotes();
    this.showScene();
  }

  private get bounds() {
    return this.scenes.find(({ name }) => name === this.sceneCard.scene)
        ?.boundsInWorldM ?? null;
  }

  private showScene(): void {
    const up = this.settings.up(this.sceneCard.scene);
    this.viewCard.setUp(up);
    this.stage.setScene(this.bounds, up);
  }

  private showNotes(): void {
    this.stage.setNotes(this.notes);
    this.notesCard.setNotes(this.notes);
  }

  private async start(): Promise<void> {
    const running = new AbortController();
    this.running = running;
    this.sceneCard.setRunning(true);
    this.status.say(LOOKING);
    try {
      const camera = await DeviceCamera.start(
          this.stage.video, () => this.stop(TAKEN));
      if (running.signal.aborted) {
        camera.stop();
        return;
      }
      this.camera = camera;
      await this.run(camera, running.signal);
    } catch (error) {
      // Its last picture may fail when a camera is stopped.
      if (running.signal.aborted) return;
      this.stop(error instanceof CameraRefused ? sayingOfCamera(error.name) :
        sayingOfError(error));
    }
  }

  // With the device's own tracking.
  private async startInSpace(): Promise<void> {
    const running = new AbortController();
    this.running = running;
    this.sceneCard.setRunning(true);
    this.status.say(LOOKING);
    let session: XRSession;
    try {
      session = await requestSpace(document.body);
    } catch (error) {
      this.stop(sayingOfSpace((error as DOMException).name));
      return;
    }
    const space = new SpaceRun(session, this.stage, {
      onState: (state) => {
        // Failures stay to be read while nothing is known.
        if (state !== this.spaceState) this.status.say(sayingOfTracking(state));
        this.spaceState = state;
      },
      onEnd: () => { if (this.space === space) this.stop(READY); },
    });
    this.space = space;
    this.spaceState = null;
    try {
      await space.begin();
      setShown(this.empty, false);
      if (running.signal.aborted) {
        space.end();
        return;
      }
      await locate(this.client, space.camera, {
        scene: this.sceneCard.scene,
        fieldOfViewDeg: () => this.fieldOfViewDeg,
        onLocated: (located) => this.onLocated(located),
      }, running.signal);
    } catch (error) {
      if (!running.signal.aborted) this.stop(sayingOfError(error));
    }
  }

  private run(camera: DeviceCamera, signal: AbortSignal): Promise<void> {
    setShown(this.empty, false);
    this.stage.setStarted(true);
    this.fieldOfViewDeg = this.settings.fieldOfViewDeg(camera.label);
    this.viewCard.setFieldOfView(this.fieldOfViewDeg);
    return locate(this.client, camera, {
      scene: this.sceneCard.scene,
      fieldOfViewDeg: () => this.fieldOfViewDeg,
      onLocated: (located) => this.onLocated(located),
    }, signal);
  }

  private stop(saying: Saying): void {
    this.running?.abort();
    this.running = null;
    this.camera?.stop();
    this.camera = null;
    const { space } = this;
    this.space = null;
    space?.end();
    this.picture = null;
    this.stage.setStarted(false);
    setShown(this.empty, true);
    this.sceneCard.setRunning(false);
    this.status.clear();
    this.status.say(saying);
  }

  private onLocated(located: Located): void {
    if (this.running === null) return;
    this.answers += 1;
    this.status.showFigures(located);
    if (this.space !== null) {
      this.onLocatedInSpace(this.space, located);
      return;
    }
    // A drawing that is not known to be right is not shown.
    this.picture = locatedPictureOf(located);
    this.stage.setPicture(this.picture, located.picture.jpeg);
    if ('error' in located) {
      this.fail(located.error);
      return;
    }
    this.status.say(sayingOfAnswer(located.answer));
    if (this.picture === null) return;
    if (located.answer.focalScale !== 1 && this.viewCard.isCorrected) {
      this.keepFieldOfView(correctedFieldOfViewDeg(this.picture.camera));
    }
    // A scene that was loaded for this answer now has its box.
    if (this.bounds === null) void this.loadBounds();
  }

  private onLocatedInSpace(space: SpaceRun, located: Located): void {
    if ('error' in located) {
      this.fail(located.error);
      this.spaceState = null;
      return;
    }
    space.add(located.answer, located.picture.captureTimeMs);
    this.status.say(space.state === 'searching' && !located.answer.localized ?
      sayingOfAnswer(located.answer) : sayingOfTracking(space.state));
    if (located.answer.localized && this.bounds === null) {
      void this.loadBounds();
    }
  }

  // What is seen now, and where from.
  private get located(): LocatedPicture | null {
    return this.space === null ? this.picture : this.space.picture;
  }

  private async loadBounds(): Promise<void> {
    try {
      this.scenes = await this.client.scenes();
      this.showScene();
    } catch {
      // The next answer asks again.
    }
  }

  // Of the chosen scene, once somebody wants to see it.
  private async loadMap(): Promise<void> {
    const { scene } = this.sceneCard;
    if (this.mapped === scene) return;
    this.mapped = scene;
    this.viewCard.say('');
    try {
      const map = await this.client.sceneMap(scene, { maxPoints: MAP_POINTS });
      if (this.mapped !== scene) return;
      this.stage.setMap(map);
      this.isMapDrawn = true;
    } catch (error) {
      if (this.mapped !== scene) return;
      // Asked again with the next click.
      this.mapped = '';
      this.viewCard.say(error instanceof TreelineError &&
          error.reason === 'NO_KEYFRAMES' ?
        'This model has no points to show.' : sayingOfError(error).text);
    }
  }

  private keepFieldOfView(fieldOfViewDeg: number): void {
    this.fieldOfViewDeg = fieldOfViewDeg;
    this.viewCard.setFieldOfView(fieldOfViewDeg);
    if (this.camera !== null) {
      this.settings.keepFieldOfView(this.camera.label, fieldOfViewDeg);
    }
  }

  // The point is taken now: the picture may be another when its text is there.
  private pin(at: PixelPoint | null): void {
    const picture = this.located;
    if (at === null || picture === null) {
      this.notesCard.say('Notes can be pinned once the camera is located.');
      return;
    }
    const pin = pinAt(picture, at, this.bounds,
        this.settings.up(this.sceneCard.scene));
    if (pin === null) {
      this.notesCard.say('Nothing is known of what is there. Point at things ' +
          'that were recorded, or at the floor.');
      return;
    }
    void this.write(null, pin.pointInWorldM, pin.from === 'points' ?
      'Pinned to what was recognised there.' : 'Pinned to the floor.');
  }

  private edit(note: Note): Promise<void> {
    return this.write(note, note.pointInWorldM, '');
  }

  private async write(note: Note | null, pointInWorldM: Note['pointInWorldM'],
      done: string): Promise<void> {
    const { scene } = this.sceneCard;
    const edit = await this.dialog.ask(note?.text ?? null);
    if (edit === 'cancelled') return;
    const others = this.notes.filter(({ id }) => id !== note?.id);
    this.notes = edit === 'deleted' ? others : [...others,
      { id: note?.id ?? newId(), text: edit.text, pointInWorldM }];
    this.notesCard.say(saveNotes(localStorage, scene, this.notes) ? done :
      'This browser keeps nothing: the notes last as long as this page.');
    this.showNotes();
    // Buttons of notes are new ones now; who wrote goes on where he was.
    if (note !== null) this.notesCard.focus(note.id);
  }
}

// crypto.randomUUID() is for secure contexts alone.
const newId = () =>
  [...crypto.getRandomValues(new Uint8Array(8))].map((byte) =>
    byte.toString(16).padStart(2, '0')).join('');

function begin(): void {
  let page: ArPage;
  try {
    page = new ArPage();
  } catch (error) {
    document.body.append(el('p', { class: 'empty' },
        'This page needs WebGL, which this browser does not give: ' +
        `${String(error)}`));
    return;
  }
  void page.loadScenes();
  void page.offerSpace();
}

begin();
