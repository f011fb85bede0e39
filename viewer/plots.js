// SPDX-License-Identifier: Apache-2.0
// Entropy of the belief, and the error of its best pose, over time.
import { modeColor, onThemeChange, theme } from './colors.js';

const GAP = 4; // px
const WORDS = 13; // px above a curve, for its name
const COLORS = { entropy: modeColor(0), rotation: '#d9688a', position: '#3aa981' };

/** Steps of a quantity: it holds until the next one. */
function steps(items, value) {
  return items
    .filter((item) => value(item) !== undefined && value(item) !== null)
    .map((item) => [item.time, value(item)]);
}

/** Entropy over the modes of an estimate, nats, as the program has it of beliefs: what they lack of
 * 1 counts as poses of which none is more probable than the least of the modes. */
export function entropyOf(weights) {
  const known = weights.filter((w) => w > 0);
  const rest = 1 - known.reduce((sum, w) => sum + w, 0);
  const listed = known.reduce((sum, p) => sum - p * Math.log(p), 0);
  return rest > 1e-9 ? listed - rest * Math.log(Math.min(rest, ...known)) : Math.max(0, listed);
}

export class Plots {
  constructor(canvas, recording) {
    this.canvas = canvas;
    this.recording = recording;
    this.now = 0;
    new ResizeObserver(() => this.draw()).observe(canvas);
    onThemeChange(() => this.draw());
  }

  show(t, withTruth) {
    this.now = t;
    this.withTruth = withTruth;
    this.draw();
  }

  /** What is plotted: rows of {name, unit, color, points}. */
  rows() {
    const { beliefs, estimates } = this.recording;
    const best = (estimate) => estimate.modes[0];
    const all = [
      ...steps(beliefs, (b) => b.entropy),
      ...steps(estimates, (e) => entropyOf(e.modes.map((mode) => mode.weight))),
    ];
    const rows = [{ name: 'entropy', unit: 'nats', color: COLORS.entropy, points: all }];
    if (!this.withTruth) return rows;
    for (const [name, key, unit] of [
      ['rotation', 'rotation_error_deg', '°'],
      ['position', 'translation_error_mm', 'mm'],
    ]) {
      const points = [
        ...steps(beliefs, (b) => b[key]),
        ...steps(estimates, (e) => best(e)?.[key]),
      ];
      if (points.length) rows.push({ name: `${name} error`, unit, color: COLORS[name], points });
    }
    return rows;
  }

  draw() {
    const ratio = devicePixelRatio;
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (!width) return;
    this.canvas.width = width * ratio;
    this.canvas.height = height * ratio;
    const c = this.canvas.getContext('2d');
    c.scale(ratio, ratio);
    c.font = '10px system-ui, sans-serif';
    const rows = this.rows();
    const each = (height - GAP * (rows.length - 1)) / rows.length;
    rows.forEach((row, i) => this.#drawRow(c, row, i * (each + GAP), width, each));
  }

  #drawRow(c, row, top, width, height) {
    const { begin, end } = this.recording;
    const x = (t) => (width * (t - begin)) / Math.max(1e-9, end - begin);
    row.points.sort((a, b) => a[0] - b[0]);
    const most = Math.max(1e-9, ...row.points.map(([, value]) => value));
    const y = (value) => top + height - 1 - (value / most) * (height - 2 - WORDS);
    c.fillStyle = theme('raised');
    c.fillRect(0, top, width, height);
    c.strokeStyle = row.color;
    c.lineWidth = 1.5;
    c.beginPath();
    row.points.forEach(([t, value], i) => {
      if (i > 0) c.lineTo(x(t), y(row.points[i - 1][1]));
      if (i === 0) c.moveTo(x(t), y(value));
      c.lineTo(x(t), y(value));
    });
    if (row.points.length) c.lineTo(x(end), y(row.points.at(-1)[1]));
    c.stroke();
    c.strokeStyle = theme('text');
    c.lineWidth = 1;
    c.beginPath();
    c.moveTo(x(this.now), top);
    c.lineTo(x(this.now), top + height);
    c.stroke();
    const at = row.points.findLast(([t]) => t <= this.now + 1e-3);
    c.fillStyle = theme('text');
    c.textBaseline = 'top';
    const value = at ? ` ${at[1].toFixed(at[1] < 10 ? 2 : 0)} ${row.unit}` : '';
    c.fillText(`${row.name}${value}`, 4, top + 2);
    c.textAlign = 'right';
    c.fillStyle = theme('quiet');
    c.fillText(row.points.length ? most.toFixed(most < 10 ? 1 : 0) : '–', width - 4, top + 2);
    c.textAlign = 'left';
  }
}
