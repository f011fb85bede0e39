// SPDX-License-Identifier: Apache-2.0
// The time bar: phases, the fingers' forces, estimates and where we are.
import { FINGER_COLORS, onThemeChange, phaseColors, theme } from './colors.js';
import { phaseLabel } from './recording.js';

const PHASES = 22; // heights, px
const TICKS = 16;
const PAD = 6;

export class Timeline {
  constructor(canvas, recording, onSeek) {
    this.canvas = canvas;
    this.recording = recording;
    this.now = recording.begin;
    const seek = (event) => onSeek(this.#timeAt(event.offsetX));
    canvas.addEventListener('pointerdown', (event) => {
      canvas.setPointerCapture(event.pointerId);
      seek(event);
    });
    canvas.addEventListener('pointermove', (event) => {
      if (event.buttons & 1) seek(event);
    });
    new ResizeObserver(() => this.draw()).observe(canvas);
    onThemeChange(() => this.draw());
  }

  show(t) {
    this.now = t;
    const { begin, end } = this.recording;
    this.canvas.ariaValueMin = begin.toFixed(2);
    this.canvas.ariaValueMax = end.toFixed(2);
    this.canvas.ariaValueNow = t.toFixed(2);
    this.draw();
  }

  #x(t) {
    const { begin, end } = this.recording;
    return PAD + ((t - begin) / Math.max(1e-9, end - begin)) * (this.width - 2 * PAD);
  }

  #timeAt(x) {
    const { begin, end } = this.recording;
    const share = (x - PAD) / Math.max(1, this.canvas.clientWidth - 2 * PAD);
    return begin + Math.min(1, Math.max(0, share)) * (end - begin);
  }

  draw() {
    const ratio = devicePixelRatio;
    this.width = this.canvas.clientWidth;
    this.height = this.canvas.clientHeight;
    if (!this.width) return;
    this.canvas.width = this.width * ratio;
    this.canvas.height = this.height * ratio;
    const c = this.canvas.getContext('2d');
    c.scale(ratio, ratio);
    c.font = '11px system-ui, sans-serif';
    c.fillStyle = theme('raised');
    c.fillRect(0, 0, this.width, this.height);
    this.#drawForces(c);
    this.#drawPhases(c);
    this.#drawTicks(c);
    this.#drawEstimates(c);
    this.#drawNow(c);
  }

  #drawPhases(c) {
    c.textBaseline = 'middle';
    const colors = phaseColors(this.recording.phases);
    this.recording.phases.forEach((phase, i) => {
      const name = phaseLabel(phase.name);
      const x = this.#x(phase.begin);
      const width = Math.max(2, this.#x(phase.end) - x - 1);
      c.globalAlpha = phase.begin <= this.now && this.now <= phase.end ? 1 : 0.72;
      c.fillStyle = colors[i];
      c.beginPath();
      c.roundRect(x, 2, width, PHASES - 4, 3);
      c.fill();
      c.globalAlpha = 1;
      if (c.measureText(name).width + 12 > width) return;
      c.fillStyle = '#ffffff';
      c.fillText(name, x + 6, PHASES / 2 + 0.5);
    });
  }

  /** Stacked over the fingers: the height is the sum of the normal forces. */
  #drawForces(c) {
    const { time, forces } = this.recording;
    const columns = this.#columns();
    const count = columns.length;
    const bottom = this.height - TICKS;
    const room = bottom - PHASES - 4;
    const below = new Float32Array(count);
    const total = (f) => forces.reduce((sum, finger) => sum + finger[f], 0);
    const most = columns.reduce((largest, f) => Math.max(largest, total(f)), 1);
    const y = (value) => bottom - (value / most) * room;
    forces.forEach((force, finger) => {
      c.beginPath();
      columns.forEach((f, i) => c.lineTo(this.#x(time[f]), y(below[i] + force[f])));
      for (let i = count - 1; i >= 0; --i) c.lineTo(this.#x(time[columns[i]]), y(below[i]));
      c.globalAlpha = 0.65;
      c.fillStyle = FINGER_COLORS[finger];
      c.fill();
      c.globalAlpha = 1;
      columns.forEach((f, i) => (below[i] += force[f]));
    });
    c.fillStyle = theme('quiet');
    c.textBaseline = 'top';
    c.fillText(`${most.toFixed(0)} N`, PAD + 2, PHASES + 3);
  }

  /** Frames that are drawn: no more than there is room for. */
  #columns() {
    const { count } = this.recording;
    const step = Math.max(1, Math.floor(count / Math.max(1, 2 * this.width)));
    const columns = [];
    for (let f = 0; f < count; f += step) columns.push(f);
    return columns;
  }

  #drawTicks(c) {
    const { begin, end } = this.recording;
    const step =
      [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 60, 120, 300, 600, 1800].find(
        (s) => ((end - begin) / s) * 56 < this.width,
      ) ?? 3600;
    c.fillStyle = theme('quiet');
    c.strokeStyle = theme('line');
    c.textBaseline = 'bottom';
    c.beginPath();
    for (let t = Math.ceil(begin / step) * step; t <= end + 1e-6; t += step) {
      const x = Math.round(this.#x(t)) + 0.5;
      c.moveTo(x, this.height - TICKS);
      c.lineTo(x, this.height - TICKS + 4);
      const label = `${+t.toFixed(1)} s`;
      const width = c.measureText(label).width;
      c.fillText(
        label,
        Math.min(Math.max(2, x - width / 2), this.width - width - 2),
        this.height - 0.5,
      );
    }
    c.moveTo(0, this.height - TICKS + 0.5);
    c.lineTo(this.width, this.height - TICKS + 0.5);
    c.stroke();
  }

  #drawEstimates(c) {
    c.fillStyle = '#2f7bf6';
    c.strokeStyle = theme('surface');
    for (const belief of this.recording.beliefs) {
      if (belief.source === 'online') continue;
      c.beginPath();
      c.arc(this.#x(belief.time), PHASES + 9, 3, 0, 2 * Math.PI);
      c.fill();
    }
    for (const estimate of this.recording.estimates) {
      const x = this.#x(estimate.time);
      const y = PHASES + 9;
      c.beginPath();
      for (const [dx, dy] of [
        [0, -6],
        [5, 0],
        [0, 6],
        [-5, 0],
      ])
        c.lineTo(x + dx, y + dy);
      c.closePath();
      c.fill();
      c.stroke();
    }
  }

  #drawNow(c) {
    const x = this.#x(this.now);
    c.strokeStyle = c.fillStyle = theme('text');
    c.lineWidth = 1.5;
    c.beginPath();
    c.moveTo(x, 0);
    c.lineTo(x, this.height - TICKS);
    c.stroke();
    c.beginPath();
    c.arc(x, 3.5, 3.5, 0, 2 * Math.PI);
    c.fill();
  }
}
