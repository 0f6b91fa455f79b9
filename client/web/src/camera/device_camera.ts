// The device's camera as a video, and its pictures as files.

import type { Pinhole, RigidTransform } from '@treeline/client';

import { sentSize } from '../model/camera_guess.js';

/** `name` is that of getUserMedia's DOMException, or InsecureContext. */
export class CameraRefused extends Error {
  constructor(override readonly name: string) {
    super(name);
  }
}

export interface Picture {
  readonly jpeg: Blob;
  readonly widthPx: number;
  readonly heightPx: number;
  readonly captureTimeMs: number;
  /** Where the device's tracking tells camera and pose. */
  readonly tracked?: TrackedView;
}

/** What a device that tracks itself knows of a picture. */
export interface TrackedView {
  readonly timeMs: number;
  readonly camera: Pinhole;
  readonly deviceFromCamera: RigidTransform;
}

export interface PictureSource {
  /** The next one. */
  picture(): Promise<Picture>;
}

/** Encodes what a canvas shows. */
export async function jpegOf(canvas: HTMLCanvasElement): Promise<Blob> {
  const jpeg = await new Promise<Blob | null>((resolve) =>
    canvas.toBlob(resolve, 'image/jpeg', JPEG_QUALITY));
  if (jpeg === null) throw new Error('the browser made no JPEG');
  return jpeg;
}

// Beyond this, more bytes hardly show the server more.
const JPEG_QUALITY = 0.9;

export class DeviceCamera implements PictureSource {
  private readonly canvas = document.createElement('canvas');

  private constructor(private readonly video: HTMLVideoElement,
      private readonly stream: MediaStream) {}

  /** Plays in `video`. Throws CameraRefused. `onEnd`: it was taken away. */
  static async start(video: HTMLVideoElement, onEnd: () => void):
      Promise<DeviceCamera> {
    if (navigator.mediaDevices === undefined) {
      throw new CameraRefused('InsecureContext');
    }
    let stream: MediaStream;
    try {
      stream = await navigator.mediaDevices.getUserMedia({
        audio: false,
        video: { facingMode: 'environment', width: { ideal: 1280 },
          height: { ideal: 960 } },
      });
    } catch (error) {
      throw new CameraRefused((error as DOMException).name);
    }
    stream.getVideoTracks()[0]?.addEventListener('ended', onEnd);
    video.srcObject = stream;
    await video.play();
    return new DeviceCamera(video, stream);
  }

  /** For what is remembered of this camera. */
  get label(): string {
    return this.stream.getVideoTracks()[0]?.label ?? '';
  }

  /** What the video shows now, at most 640x480. */
  async picture(): Promise<Picture> {
    const { widthPx, heightPx } =
        sentSize(this.video.videoWidth, this.video.videoHeight);
    this.canvas.width = widthPx;
    this.canvas.height = heightPx;
    const captureTimeMs = performance.now();
    this.canvas.getContext('2d')!
        .drawImage(this.video, 0, 0, widthPx, heightPx);
    const jpeg = await jpegOf(this.canvas);
    return { jpeg, widthPx, heightPx, captureTimeMs };
  }

  stop(): void {
    for (const track of this.stream.getTracks()) track.stop();
    this.video.srcObject = null;
  }
}
