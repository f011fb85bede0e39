// SPDX-License-Identifier: Apache-2.0
// The recording as the page embeds it (src/recording/page_data.cpp), decoded.

export const POSE = 7; // x, y, z, qx, qy, qz, qw
const CONTACT = 7; // point, outward normal, force along it
const LEAST_WEIGHT = 0.05; // of a mode shown unasked

export const FINGERS = ['thumb', 'first', 'middle', 'ring', 'little'];

function bytes(text) {
  const raw = atob(text);
  const out = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; ++i) out[i] = raw.charCodeAt(i);
  return out;
}

export const floats = (text) => new Float32Array(bytes(text).buffer);
export const uints = (text) => new Uint32Array(bytes(text).buffer);

/** A phase's name as it is shown. */
export const phaseLabel = (name) => name.replaceAll('_', ' ');

/** Light modes are off until asked for. */
export function modeShown(shown, estimate, i) {
  return shown.modes[i] ?? (i === 0 || estimate.modes[i].weight >= LEAST_WEIGHT);
}

export class Recording {
  constructor(data) {
    const f = data.frames;
    Object.assign(this, data);
    this.count = f.count;
    this.links = f.links;
    this.palm = f.palm;
    this.time = floats(f.time);
    this.linkPoses = floats(f.link_poses);
    this.objectPoses = floats(f.object_poses);
    this.hasObject = bytes(f.has_object);
    this.contactValues = floats(f.contacts);
    this.contactFingers = bytes(f.contact_fingers);
    this.contactStart = new Uint32Array(f.count + 1);
    uints(f.contact_counts).forEach((n, i) => {
      this.contactStart[i + 1] = this.contactStart[i] + n;
    });
    this.posteriors ??= [];
    this.begin = this.count ? this.time[0] : 0;
    this.end = this.count ? this.time[this.count - 1] : 0;
    this.forces = this.#forces();
  }

  /** Index of the last frame up to time t. */
  frameAt(t) {
    let low = 0;
    let high = this.count - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.time[middle] <= t + 1e-6) low = middle;
      else high = middle - 1;
    }
    return low;
  }

  /** Frame before t and the share of the way to the next one. */
  between(t) {
    const frame = this.frameAt(t);
    if (frame + 1 >= this.count) return { frame, share: 0 };
    const span = this.time[frame + 1] - this.time[frame];
    return { frame, share: span > 0 ? Math.min(1, Math.max(0, (t - this.time[frame]) / span)) : 0 };
  }

  contacts(frame) {
    const list = [];
    for (let i = this.contactStart[frame]; i < this.contactStart[frame + 1]; ++i) {
      const v = this.contactValues.subarray(i * CONTACT, (i + 1) * CONTACT);
      list.push({
        finger: this.contactFingers[i],
        p: v.subarray(0, 3),
        n: v.subarray(3, 6),
        force: v[6],
      });
    }
    return list;
  }

  phaseAt(t) {
    let found = -1;
    this.phases.forEach((phase, i) => {
      if (phase.begin <= t + 1e-6) found = i;
    });
    return found;
  }

  /**
   * Time from which the first estimate is drawn, in hindsight: in the phase before, the object was
   * already held as it was felt to be, as long as two fingers touched it without a break.
   */
  heldSince(estimate) {
    const phase = this.phaseAt(estimate.time);
    const earliest = phase > 0 ? this.phases[phase - 1].begin : estimate.time;
    let frame = this.frameAt(estimate.time);
    const touching = (f) => this.forces.filter((finger) => finger[f] > 0).length >= 2;
    while (frame > 0 && this.time[frame - 1] >= earliest && touching(frame - 1)) --frame;
    return this.count ? Math.min(estimate.time, this.time[frame]) : estimate.time;
  }

  /** Index of the estimate to draw at time t, or -1. */
  estimateAt(t) {
    const index = this.estimates.findLastIndex((estimate) => estimate.time <= t + 1e-3);
    if (index >= 0 || !this.estimates.length) return index;
    return t + 1e-3 >= this.heldSince(this.estimates[0]) ? 0 : -1;
  }

  /**
   * Index of the posterior of the resting object to draw at time t, or -1: none once the pose in
   * the hand has been estimated from a later grasp.
   */
  posteriorAt(t) {
    const index = this.posteriors.findLastIndex((posterior) => posterior.time <= t + 1e-3);
    const estimate = this.estimateAt(t);
    if (index < 0 || estimate < 0) return index;
    return this.posteriors[index].time > this.estimates[estimate].time ? index : -1;
  }

  /** Force of each finger in each frame, N. */
  #forces() {
    const forces = FINGERS.map(() => new Float32Array(this.count));
    for (let frame = 0; frame < this.count; ++frame) {
      for (const contact of this.contacts(frame))
        forces[contact.finger][frame] += Math.max(0, contact.force);
    }
    return forces;
  }
}
