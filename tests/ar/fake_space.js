// A device in place of WebXR's: it tracks itself without error, and its camera
// shows recorded frames. What the page asks of a real one is here, and no more.

// Runs in the page, before all else. `frames`: {matrix: deviceFromView, by
// columns, jpeg: base64}, shown forth and back at `rateHz`; `projection`: by
// columns. `refusal`: the DOMException with which sessions are refused.
export function installFakeSpace({ frames, projection, rateHz, refusal }) {
  const device = { shown: -1, sessions: [], asked: null, views: 0 };
  window.fakeSpace = device;
  const bitmaps = Promise.all(frames.map(async ({ jpeg }) => {
    const bytes = Uint8Array.from(atob(jpeg), (c) => c.charCodeAt(0));
    const picture = await createImageBitmap(new Blob([bytes]));
    // Cameras of phones have more pixels than are sent. v points up.
    return createImageBitmap(picture, { imageOrientation: 'flipY',
      resizeWidth: 2 * picture.width, resizeHeight: 2 * picture.height,
      resizeQuality: 'pixelated' });
  }));
  let pictures = [];
  const frameAt = (view) => {
    const at = view % (2 * frames.length - 2);
    return at < frames.length ? at : 2 * frames.length - 2 - at;
  };

  class Session extends EventTarget {
    enabledFeatures = ['viewer', 'local', 'camera-access', 'dom-overlay'];
    environmentBlendMode = 'alpha-blend';
    inputSources = [];
    renderState = {};
    #timers = new Map();
    #next = 1;
    ended = false;

    updateRenderState(state) { Object.assign(this.renderState, state); }
    async requestReferenceSpace() { return new EventTarget(); }

    requestAnimationFrame(callback) {
      const id = this.#next++;
      this.#timers.set(id, setTimeout(() => {
        this.#timers.delete(id);
        device.shown = frameAt(device.views++);
        const index = device.shown;
        const { width, height } = pictures[index];
        const transform = { matrix: new Float32Array(frames[index].matrix) };
        const view = { eye: 'none', transform, camera: { width, height },
          projectionMatrix: new Float32Array(projection) };
        callback(performance.now(), { session: this,
          getViewerPose: () =>
            ({ transform, views: [view], emulatedPosition: false }) });
      }, 1000 / rateHz));
      return id;
    }

    cancelAnimationFrame(id) {
      clearTimeout(this.#timers.get(id));
      this.#timers.delete(id);
    }

    async end() {
      if (this.ended) throw new DOMException('', 'InvalidStateError');
      this.ended = true;
      for (const timer of this.#timers.values()) clearTimeout(timer);
      this.#timers.clear();
      this.dispatchEvent(new Event('end'));
    }
  }

  const xr = new EventTarget();
  xr.isSessionSupported = async (mode) => mode === 'immersive-ar';
  xr.requestSession = async (mode, init) => {
    device.asked = { mode, features: init.requiredFeatures };
    if (refusal) throw new DOMException('', refusal);
    pictures = await bitmaps;
    const session = new Session();
    device.sessions.push(session);
    return session;
  };
  Object.defineProperty(navigator, 'xr', { value: xr });

  // The page's own canvas is what is seen.
  window.XRWebGLLayer = class {
    framebuffer = null;
    framebufferWidth = 960;
    framebufferHeight = 720;
    ignoreDepthValues = true;
    getViewport() {
      return { x: 0, y: 0, width: this.framebufferWidth,
        height: this.framebufferHeight };
    }
  };
  window.XRWebGLBinding = class {
    #texture;
    constructor(session, gl) {
      this.gl = gl;
      this.#texture = gl.createTexture();
    }
    getCameraImage() {
      const { gl } = this;
      const bound = gl.getParameter(gl.TEXTURE_BINDING_2D);
      gl.bindTexture(gl.TEXTURE_2D, this.#texture);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
      gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, gl.RGBA, gl.UNSIGNED_BYTE,
          pictures[device.shown]);
      gl.bindTexture(gl.TEXTURE_2D, bound);
      return this.#texture;
    }
  };
  WebGL2RenderingContext.prototype.makeXRCompatible = async () => {};
}
