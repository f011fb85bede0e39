// SPDX-License-Identifier: Apache-2.0
// The recording as the page embeds it (src/recording/page_data.cpp), decoded.

export const POSE = 7; // x, y, z, qx, qy, qz, qw
const CONTACT = 7; // point, outward normal, force along it

export const FINGERS = ['thumb', 'first', 'middle', 'ring', 'little'];

function bytes(text) {
  const raw = atob(text);
  const out = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; ++i) out[i] = raw.charCodeAt(i);
  return out;
}

export const floats = (text) => new Float32Array(bytes(text).buffer);
export const uints = (text) => new Uint32Array(bytes(text).buffer);

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
      list.push({ finger: this.contactFingers[i], p: v.subarray(0, 3), n: v.subarray(3, 6), force: v[6] });
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

  /** Time from which an estimate is drawn: that of its first contact, since it holds the object since. */
  heldSince(estimate) {
    const times = estimate.contacts.map((contact) => contact.time).filter((t) => t > 0);
    return Math.min(estimate.time, ...times);
  }

  /** Index of the estimate to draw at time t, or -1. */
  estimateAt(t) {
    return this.estimates.findIndex((estimate, i) => {
      const next = this.estimates[i + 1];
      return t + 1e-3 >= this.heldSince(estimate) && (!next || t < Math.max(estimate.time, this.heldSince(next)));
    });
  }

  /** Force of each finger in each frame, N. */
  #forces() {
    const forces = FINGERS.map(() => new Float32Array(this.count));
    for (let frame = 0; frame < this.count; ++frame) {
      for (const contact of this.contacts(frame)) forces[contact.finger][frame] += Math.max(0, contact.force);
    }
    return forces;
  }
}
