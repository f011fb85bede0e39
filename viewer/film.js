// SPDX-License-Identifier: Apache-2.0
// The three-dimensional view as a video file, made by the browser while it plays.

const RATE = 30; // pictures a second
const BITS = 8e6; // a second
const KINDS = ['video/mp4;codecs=avc1.42E01E', 'video/webm;codecs=vp9', 'video/webm'];

/** The kinds of video that this browser makes. */
export const filmKinds = () =>
  typeof MediaRecorder === 'undefined' ? [] : KINDS.filter((k) => MediaRecorder.isTypeSupported(k));

export class Film {
  /** @param words  () => [title, text] that stand in the picture */
  constructor(name, words) {
    this.name = name;
    this.words = words;
    this.canvas = document.createElement('canvas');
    this.context = this.canvas.getContext('2d');
  }

  get running() {
    return this.recorder?.state === 'recording';
  }

  start(view) {
    this.canvas.width = view.width & ~1;
    this.canvas.height = view.height & ~1;
    this.picture(view);
    const kind = filmKinds()[0];
    const pieces = [];
    this.recorder = new MediaRecorder(this.canvas.captureStream(RATE), {
      mimeType: kind,
      videoBitsPerSecond: BITS,
    });
    this.recorder.addEventListener('dataavailable', (event) => pieces.push(event.data));
    this.recorder.addEventListener('stop', () => this.#save(new Blob(pieces, { type: kind }), kind));
    this.recorder.start();
  }

  stop() {
    if (this.running) this.recorder.stop();
  }

  /** Takes up what has just been drawn. */
  picture(view) {
    const c = this.context;
    c.drawImage(view, 0, 0, this.canvas.width, this.canvas.height);
    const size = Math.max(14, Math.round(this.canvas.height / 36));
    c.fillStyle = getComputedStyle(document.body).color;
    c.textBaseline = 'top';
    this.words().forEach((text, i) => {
      c.font = `${i === 0 ? 600 : 400} ${size}px system-ui, sans-serif`;
      c.fillText(text, size, size * (0.8 + 1.35 * i));
    });
  }

  #save(blob, kind) {
    this.saved = blob.size;
    const link = document.createElement('a');
    link.href = URL.createObjectURL(blob);
    link.download = `${this.name}.${kind.includes('mp4') ? 'mp4' : 'webm'}`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 60000);
  }
}
