// SPDX-License-Identifier: Apache-2.0
// The time bar: phases, the fingers' forces, estimates and where we are.
import { FINGER_COLORS, onThemeChange, phaseColors, theme } from './colors.js';
import { FINGERS, phaseLabel } from './recording.js';

const PHASES = 22; // heights, px
const TICKS = 16;
const PAD = 6;

export class Timeline {
  constructor(canvas, recording, onSeek) {
    this.canvas = canvas;
    this.recording = recording;
    this.colors = phaseColors(recording.phases);
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
    this.recording.phases.forEach((phase, i) => {
      const name = phaseLabel(phase.name);
      const x = this.#x(phase.begin);
      const width = Math.max(2, this.#x(phase.end) - x - 1);
      c.globalAlpha = phase.begin <= this.now && this.now <= phase.end ? 1 : 0.72;
      c.fillStyle = this.colors[i];
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
    const { count, time, forces } = this.recording;
    const bottom = this.height - TICKS;
    const room = bottom - PHASES - 4;
    const below = new Float32Array(count);
    let most = 1;
    for (let f = 0; f < count; ++f)
      most = Math.max(
        most,
        forces.reduce((sum, finger) => sum + finger[f], 0),
      );
    const y = (value) => bottom - (value / most) * room;
    FINGERS.forEach((_, finger) => {
      c.beginPath();
      for (let f = 0; f < count; ++f) c.lineTo(this.#x(time[f]), y(below[f] + forces[finger][f]));
      for (let f = count - 1; f >= 0; --f) c.lineTo(this.#x(time[f]), y(below[f]));
      c.globalAlpha = 0.65;
      c.fillStyle = FINGER_COLORS[finger];
      c.fill();
      c.globalAlpha = 1;
      for (let f = 0; f < count; ++f) below[f] += forces[finger][f];
    });
    c.fillStyle = theme('quiet');
    c.textBaseline = 'top';
    c.fillText(`${most.toFixed(0)} N`, PAD + 2, PHASES + 3);
  }

  #drawTicks(c) {
    const { begin, end } = this.recording;
    const step =
      [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 60, 120, 300].find(
        (s) => ((end - begin) / s) * 56 < this.width,
      ) ?? 600;
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
    for (const posterior of this.recording.posteriors) {
      c.beginPath();
      c.arc(this.#x(posterior.time), PHASES + 9, 3, 0, 2 * Math.PI);
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
