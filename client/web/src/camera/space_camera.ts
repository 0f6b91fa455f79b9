// WebXR with camera access: a device that tracks itself and shows us its
// pictures. See https://www.w3.org/TR/webxr/ and
// https://immersive-web.github.io/raw-camera-access/.

import { cameraFromWebXr, deviceFromCameraOfWebXr, type Pinhole } from
  '@treeline/client';
import * as THREE from 'three';

import { sentSize } from '../model/camera_guess.js';
import { jpegOf, type Picture, type PictureSource, type TrackedView } from
  './device_camera.js';

// Of the module raw-camera-access.
interface XrCamera {
  readonly width: number;
  readonly height: number;
}
type ViewWithCamera = XRView & { readonly camera?: XrCamera };

/** Whether this browser has sessions in the space around the device. */
export async function hasSpace(): Promise<boolean> {
  try {
    return await navigator.xr?.isSessionSupported('immersive-ar') ?? false;
  } catch {
    return false;
  }
}

/**
 * Must be called from a click. `root` is shown over the space. Rejects with a
 * DOMException where the device gives no camera to pages.
 */
export const requestSpace = (root: Element): Promise<XRSession> =>
  navigator.xr!.requestSession('immersive-ar', {
    requiredFeatures: ['local', 'camera-access', 'dom-overlay'],
    domOverlay: { root },
  });

// Averages as many samples a side as pixels of the camera go into one.
const VERTEX = `
  varying vec2 at;
  void main() {
    at = uv;
    gl_Position = vec4(position.xy, 0.0, 1.0);
  }`;
const FRAGMENT = `
  uniform sampler2D image;
  uniform vec2 pixel;
  uniform int taps;
  varying vec2 at;
  void main() {
    vec3 sum = vec3(0.0);
    for (int i = 0; i < taps; ++i) {
      for (int j = 0; j < taps; ++j) {
        vec2 within = (vec2(i, j) + 0.5) / float(taps) - 0.5;
        sum += texture2D(image, at + within * pixel).rgb;
      }
    }
    gl_FragColor = vec4(sum / float(taps * taps), 1.0);
  }`;

/** Reads textures of the device's camera, smaller than they are. */
class CameraReader {
  private readonly target = new THREE.WebGLRenderTarget(1, 1);
  private readonly material = new THREE.ShaderMaterial({
    vertexShader: VERTEX, fragmentShader: FRAGMENT,
    depthTest: false, depthWrite: false,
    uniforms: { image: { value: null }, taps: { value: 1 },
      pixel: { value: new THREE.Vector2() } } });
  private readonly quad =
      new THREE.Mesh(new THREE.PlaneGeometry(2, 2), this.material);
  private readonly camera = new THREE.Camera();
  private readonly canvas = document.createElement('canvas');

  constructor(private readonly renderer: THREE.WebGLRenderer) {
    this.quad.frustumCulled = false;
  }

  /** Within the callback of the frame that has the texture. */
  read(texture: THREE.Texture, from: XrCamera, widthPx: number,
      heightPx: number): void {
    const { uniforms } = this.material;
    uniforms.image!.value = texture;
    uniforms.taps!.value = Math.max(1, Math.round(from.width / widthPx));
    (uniforms.pixel!.value as THREE.Vector2).set(1 / widthPx, 1 / heightPx);
    this.target.setSize(widthPx, heightPx);
    const shown = this.renderer.getRenderTarget();
    const rgba = new Uint8Array(4 * widthPx * heightPx);
    this.renderer.xr.enabled = false;
    this.renderer.setRenderTarget(this.target);
    this.renderer.render(this.quad, this.camera);
    this.renderer.readRenderTargetPixels(
        this.target, 0, 0, widthPx, heightPx, rgba);
    this.renderer.setRenderTarget(shown);
    this.renderer.xr.enabled = true;
    // Rows from the bottom become rows from the top.
    const picture = new ImageData(widthPx, heightPx);
    for (let y = 0; y < heightPx; ++y) {
      const row = 4 * widthPx * (heightPx - 1 - y);
      picture.data.set(rgba.subarray(row, row + 4 * widthPx), 4 * widthPx * y);
    }
    this.canvas.width = widthPx;
    this.canvas.height = heightPx;
    this.canvas.getContext('2d')!.putImageData(picture, 0, 0);
  }

  jpeg(): Promise<Blob> {
    return jpegOf(this.canvas);
  }

  dispose(): void {
    this.target.dispose();
    this.material.dispose();
    this.quad.geometry.dispose();
  }
}

/** The camera of a session that `renderer` presents. */
export class SpaceCamera implements PictureSource {
  private readonly reader: CameraReader;
  private wanted: ((picture: Promise<Picture>) => void) | null = null;

  constructor(private readonly renderer: THREE.WebGLRenderer) {
    this.reader = new CameraReader(renderer);
  }

  /** Of the next frame that has one. */
  picture(): Promise<Picture> {
    return new Promise((resolve) => { this.wanted = resolve; });
  }

  /** In each frame: where the camera is; null: the device does not know. */
  onFrame(timeMs: number, frame: XRFrame): TrackedView | null {
    const space = this.renderer.xr.getReferenceSpace();
    const pose = space === null ? undefined : frame.getViewerPose(space);
    const view = pose?.views.find(
        (each: ViewWithCamera) => each.camera !== undefined) as
        ViewWithCamera | undefined;
    if (view === undefined) return null;
    const from = view.camera!;
    const { widthPx, heightPx } = sentSize(from.width, from.height);
    const [fxPx, fyPx, cxPx, cyPx] = cameraFromWebXr(
        view.projectionMatrix, widthPx, heightPx).parameters;
    const camera = { widthPx, heightPx, fxPx, fyPx, cxPx, cyPx } as Pinhole;
    const tracked = { timeMs, camera,
      deviceFromCamera: deviceFromCameraOfWebXr(view.transform.matrix) };
    const { wanted } = this;
    const texture = wanted && textureOf(this.renderer, from);
    // Where tracking is guessed, a picture would be sent with a wrong pose.
    if (texture && pose?.emulatedPosition !== true) {
      this.wanted = null;
      this.reader.read(texture, from, widthPx, heightPx);
      wanted(this.reader.jpeg().then((jpeg) =>
        ({ jpeg, widthPx, heightPx, captureTimeMs: timeMs, tracked })));
    }
    return tracked;
  }

  stop(): void {
    this.reader.dispose();
  }
}

// three.js has it from XRWebGLBinding.getCameraImage().
const textureOf = (renderer: THREE.WebGLRenderer, camera: XrCamera):
    THREE.Texture | null =>
  (renderer.xr as unknown as {
    getCameraTexture(of: XrCamera): THREE.Texture | undefined;
  }).getCameraTexture(camera) ?? null;
