// SPDX-License-Identifier: Apache-2.0
// The panel at the side: what the recording is, forces, phases, the estimate and what is shown.
import { FINGER_COLORS, modeColor, phaseColors } from './colors.js';
import { modeShown, phaseLabel } from './recording.js';

const FULL_FORCE = 20; // N, a full meter

/** Element with attributes and children; text is never parsed as HTML. */
function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name === 'color') element.style.background = value;
    else if (name.startsWith('on')) element.addEventListener(name.slice(2), value);
    else element[name] = value;
  }
  element.append(...children);
  return element;
}

const MODES_LISTED = 5; // until asked for more

/** "ok: 91 mm tall" as a check mark and words. */
function outcome(text) {
  const [, status, words] = /^(ok|failed|timed[ _]out)(?:: )?(.*)$/s.exec(text) ?? [
    undefined,
    '',
    text,
  ];
  const marks = { ok: ['good', '✓ '], '': ['quiet', ''] };
  const [style, mark] = marks[status] ?? ['warn', `${status.replace('_', ' ')}: `];
  return make('span', { className: 'outcome' }, make('span', { className: style }, mark), words);
}

const swatch = (color) => make('span', { className: 'swatch', color });
const byId = (id) => document.getElementById(id);
const known = (value, unit) => (value === undefined || value === null ? '–' : `${value.toFixed(1)}${unit}`);

export class Panel {
  /** @param shown what is switched on, changed in place @param actions {seek(t), changed()} */
  constructor(recording, title, shown, actions) {
    this.recording = recording;
    this.shown = shown;
    this.actions = actions;
    byId('title').textContent = title;
    this.#fillAbout();
    this.#fillForces();
    this.#fillPhases();
    this.#fillLayers();
  }

  show(t) {
    const frame = this.recording.frameAt(t);
    this.meters.forEach(({ bar, text }, finger) => {
      const force = this.recording.count ? this.recording.forces[finger][frame] : 0;
      bar.style.width = `${Math.min(100, (100 * force) / FULL_FORCE)}%`;
      text.textContent = force > 0 ? `${force.toFixed(1)} N` : '–';
    });
    const phase = this.recording.phaseAt(t);
    this.phaseRows.forEach((row, i) => row.classList.toggle('now', i === phase));
    this.#fillEstimate(t);
  }

  #fillAbout() {
    const r = this.recording;
    const parts = [
      `${r.object}, ${Math.round(1000 * r.mass)} g`,
      `seed ${r.seed}`,
      `palpate ${r.program_version}`,
    ];
    if (r.symmetries > 1) parts.splice(1, 0, `symmetry of order ${r.symmetries}`);
    byId('about').append(parts.join(' · '));
    if (!r.finished)
      byId('about').append(' ', make('span', { className: 'badge warn' }, 'unfinished recording'));
  }

  #fillForces() {
    this.meters = this.recording.fingers.map((name, finger) => {
      const bar = make('i', { color: FINGER_COLORS[finger] });
      const text = make('span', { className: 'newton quiet' });
      byId('forces').append(
        make(
          'div',
          { className: 'row' },
          make('span', { className: 'finger', title: name }, name),
          make('span', { className: 'meter' }, bar),
          text,
        ),
      );
      return { bar, text };
    });
  }

  #fillPhases() {
    const listed = JSON.stringify(this.recording.phases);
    if (listed === this.phasesListed) return;
    this.phasesListed = listed;
    const colors = phaseColors(this.recording.phases);
    this.phaseRows = this.recording.phases.map((phase, i) =>
      make(
        'button',
        { className: 'row', onclick: () => this.actions.seek(phase.begin) },
        swatch(colors[i]),
        make('span', { className: 'grow' }, phaseLabel(phase.name), outcome(phase.outcome)),
        make('span', { className: 'quiet' }, `${(phase.end - phase.begin).toFixed(1)} s`),
      ),
    );
    const none = make('span', { className: 'quiet' }, 'none recorded');
    byId('phases').replaceChildren(...(this.phaseRows.length ? this.phaseRows : [none]));
  }

  /** Lists the phases that have been recorded since. */
  update() {
    this.#fillPhases();
  }

  #fillBelief(belief) {
    const count = belief.poses.length;
    const best = belief.poses[0]?.probability ?? 0;
    const error = belief.rotation_error_deg;
    const words = {
      prior: 'Before the first touch: every stable pose, every yaw.',
      touch: 'Poses consistent with the touches so far; more probable ones are more opaque.',
    };
    byId('estimate').replaceChildren(
      make(
        'div',
        { className: 'row' },
        make(
          'span',
          { className: `badge ${count === 1 ? 'good' : 'warn'}` },
          belief.in_hand ? 'in hand' : 'exploring',
        ),
        make(
          'span',
          { className: 'grow' },
          count
            ? `${count} credible pose${count === 1 ? '' : 's'}${best < 0.005 ? '' : `, best ${best.toFixed(2)}`}`
            : 'no pose explains the touches',
        ),
      ),
      make(
        'div',
        { className: 'quiet' },
        this.shown.truth && error !== undefined && error !== null
          ? `Best pose: ${known(error, '°')}, ${known(belief.translation_error_mm, ' mm')} from the true one.`
          : (words[belief.source] ?? 'Poses consistent with the contacts of the fingertips.'),
      ),
    );
  }

  /** The belief or estimate drawn at t. */
  #fillEstimate(t) {
    const { estimates, beliefs } = this.recording;
    const believed = this.recording.beliefAt(t);
    const index = believed < 0 ? this.recording.estimateAt(t) : -1;
    const item = beliefs[believed] ?? estimates[index];
    const key = item ?? 'none';
    if (key === this.estimateShown && this.truthShown === this.shown.truth) return;
    this.estimateShown = key;
    this.truthShown = this.shown.truth;
    if (believed >= 0) this.#fillBelief(item);
    else if (index >= 0) this.#fillModes(item);
    else
      byId('estimate').replaceChildren(
        make('span', { className: 'quiet' }, estimates.length ? 'none yet' : 'none recorded'),
      );
  }

  #fillModes(estimate) {
    const head = make(
      'tr',
      {},
      ...['pose', 'weight', 'rotation', 'position'].map((text) => make('th', {}, text)),
    );
    const rows = estimate.modes.map((mode, i) => this.#modeRow(estimate, i));
    const lighter = rows.slice(MODES_LISTED);
    for (const row of lighter) row.hidden = true;
    const more = make(
      'button',
      {
        hidden: !lighter.length,
        onclick: () => {
          for (const row of lighter) row.hidden = false;
          more.hidden = true;
        },
      },
      `${lighter.length} less probable poses`,
    );
    const recorded = estimate.modes.some((mode) => mode.rotation_error_deg !== undefined);
    const evaluated = recorded && this.shown.truth;
    const state = estimate.status === 'certain' ? 'good' : 'warn';
    byId('estimate').replaceChildren(
      make(
        'div',
        { className: 'row' },
        make('span', { className: `badge ${state}` }, estimate.status.replace('_', ' ')),
        make('span', { className: 'grow quiet' }, `from ${estimate.contacts.length} contacts`),
        make(
          'button',
          { onclick: () => this.actions.seek(estimate.time) },
          `at ${estimate.time.toFixed(2)} s`,
        ),
      ),
      make('table', {}, head, ...rows),
      more,
      make(
        'div',
        { className: 'quiet' },
        evaluated
          ? 'Rotation and position: error against the true pose, modulo symmetry. '
          : recorded
            ? 'Key T shows the true pose and the errors. '
            : 'The true pose was not recorded. ',
        estimate.contacts.length
          ? 'At other times the poses move with the palm.'
          : 'The object rests until two fingers touch it.',
      ),
    );
  }

  #modeRow(estimate, i) {
    const mode = estimate.modes[i];
    const box = make('input', {
      type: 'checkbox',
      checked: modeShown(this.shown, estimate, i),
      onchange: (event) => {
        this.shown.modes[i] = event.target.checked;
        this.actions.changed();
      },
    });
    const free = mode.free_axis ? ` ⟳ ±${Math.round(mode.free_axis.extent_deg)}°` : '';
    return make(
      'tr',
      {},
      make('td', {}, make('label', {}, box, swatch(modeColor(i)), `${i + 1}${free}`)),
      make('td', {}, `${(100 * mode.weight).toFixed(0)} %`),
      make('td', {}, known(this.shown.truth ? mode.rotation_error_deg : undefined, '°')),
      make('td', {}, known(this.shown.truth ? mode.translation_error_mm : undefined, ' mm')),
    );
  }

  #fillLayers() {
    const r = this.recording;
    const has = (items) => r.live || items.some((x) => x);
    const layers = [
      ['truth', 'Object, true pose (T)', 'var(--truth)', has(Array.from(r.hasObject))],
      ['estimate', 'Object, credible poses', modeColor(0), has([...r.estimates, ...r.beliefs])],
      ['touches', 'Touches so far', FINGER_COLORS[0], true],
      ['contacts', 'Contacts; arrows show the force', FINGER_COLORS[0], true],
      ['evidence', 'Contacts used by the estimate', FINGER_COLORS[2], has(r.estimates)],
      ['hand', 'Hand, at its measured joint angles', '#8d98a6', true],
      ['seeThrough', 'Transparent hand (H)', '', true],
      ['follow', 'Follow the hand (F)', '', true],
      ['skip', 'Skip times without contact (D)', '', true],
    ];
    this.boxes = {};
    for (const [key, text, color, there] of layers) {
      if (!there) continue;
      const box = make('input', {
        type: 'checkbox',
        checked: this.shown[key],
        onchange: (event) => {
          this.shown[key] = event.target.checked;
          this.actions.changed();
        },
      });
      this.boxes[key] = box;
      byId('layers').append(
        make(
          'label',
          { className: 'row' },
          box,
          swatch(color || 'transparent'),
          make('span', { className: 'grow' }, text),
        ),
      );
    }
  }

  /** Sets the boxes to what is shown. */
  showLayers() {
    for (const [key, box] of Object.entries(this.boxes)) box.checked = this.shown[key];
  }
}
