// SPDX-License-Identifier: Apache-2.0
// The recording as the page embeds it (src/recording/page_data.cpp), decoded. A live one grows.

export const POSE = 7; // x, y, z, qx, qy, qz, qw
const CONTACT = 7; // point, outward normal, force along it
const LEAST_WEIGHT = 0.05; // of a mode shown unasked
const MAX_FRAMES = 60000; // of a live recording; then the older half is dropped

const FINGER_NAMES = { TH: 'thumb', FF: 'first', MF: 'middle', RF: 'ring', LF: 'little' };

function bytes(text) {
  const raw = atob(text);
  const out = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; ++i) out[i] = raw.charCodeAt(i);
  return out;
}

export const floats = (text) => new Float32Array(bytes(text).buffer);
export const uints = (text) => new Uint32Array(bytes(text).buffer);

/** A phase's name as it is shown. */
export const phaseLabel = (name) => name.replaceAll(/[_-]/g, ' ');

/** Light modes are off until asked for. */
export function modeShown(shown, estimate, i) {
  return shown.modes[i] ?? (i === 0 || estimate.modes[i].weight >= LEAST_WEIGHT);
}

/** Numbers to which more are added. */
class Series {
  constructor(Kind) {
    this.room = new Kind(0);
    this.length = 0;
  }

  get values() {
    return this.room.subarray(0, this.length);
  }

  add(values) {
    const length = this.length + values.length;
    if (length > this.room.length) {
      const room = new this.room.constructor(this.length ? 2 * length : length);
      room.set(this.values);
      this.room = room;
    }
    this.room.set(values, this.length);
    this.length = length;
  }

  dropFirst(count) {
    this.room = this.room.slice(count, this.length);
    this.length -= count;
  }
}

export class Recording {
  constructor(data) {
    Object.assign(this, data);
    this.fingers = data.fingers.map((name) => FINGER_NAMES[name] ?? name);
    this.series = {
      time: new Series(Float32Array),
      links: new Series(Float32Array),
      object: new Series(Float32Array),
      hasObject: new Series(Uint8Array),
      contacts: new Series(Float32Array),
      contactFingers: new Series(Uint8Array),
      contactStart: new Series(Uint32Array),
    };
    this.series.contactStart.add([0]);
    this.forceSeries = this.fingers.map(() => new Series(Float32Array));
    this.addFrames(data.frames);
  }

  /** Appends frames as page_data.cpp writes them. */
  addFrames(f) {
    if (this.time?.length > MAX_FRAMES) this.#dropHalf();
    const s = this.series;
    const first = s.time.length;
    s.time.add(floats(f.time));
    s.links.add(floats(f.link_poses));
    s.object.add(floats(f.object_poses));
    s.hasObject.add(bytes(f.has_object));
    s.contacts.add(floats(f.contacts));
    s.contactFingers.add(bytes(f.contact_fingers));
    let end = s.contactStart.values[s.contactStart.length - 1];
    s.contactStart.add(uints(f.contact_counts).map((n) => (end += n)));
    this.#refresh();
    this.#addForces(first);
  }

  #refresh() {
    const s = this.series;
    this.count = s.time.length;
    this.time = s.time.values;
    this.linkPoses = s.links.values;
    this.objectPoses = s.object.values;
    this.hasObject = s.hasObject.values;
    this.begin = this.count ? this.time[0] : 0;
    this.end = this.count ? this.time[this.count - 1] : 0;
  }

  #dropHalf() {
    const s = this.series;
    const drop = this.count >> 1;
    const contacts = s.contactStart.values[drop];
    s.time.dropFirst(drop);
    s.links.dropFirst(drop * this.links * POSE);
    s.object.dropFirst(drop * POSE);
    s.hasObject.dropFirst(drop);
    s.contacts.dropFirst(contacts * CONTACT);
    s.contactFingers.dropFirst(contacts);
    s.contactStart.dropFirst(drop);
    s.contactStart.room = s.contactStart.values.map((at) => at - contacts);
    for (const forces of this.forceSeries) forces.dropFirst(drop);
    this.beliefs = this.beliefs.filter((belief) => belief.time >= this.time[drop]);
  }

  addBelief(belief) {
    const after = this.beliefs.findLastIndex((known) => known.time <= belief.time);
    this.beliefs.splice(after + 1, 0, belief);
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
    const start = this.series.contactStart.room;
    for (let i = start[frame]; i < start[frame + 1]; ++i) {
      const v = this.series.contacts.room.subarray(i * CONTACT, (i + 1) * CONTACT);
      list.push({
        finger: this.series.contactFingers.room[i],
        p: v.subarray(0, 3),
        n: v.subarray(3, 6),
        force: v[6],
      });
    }
    return list;
  }

  phaseAt(t) {
    return this.phases.findLastIndex((phase) => phase.begin <= t + 1e-6);
  }

  /**
   * Time from which the first estimate is drawn, in hindsight: in the phase before, the object was
   * already held at the estimated pose, as long as two fingers touched it without a break.
   */
  heldSince(estimate) {
    const phase = this.phaseAt(estimate.time);
    const earliest = phase > 0 ? this.phases[phase - 1].begin : estimate.time;
    let frame = this.frameAt(estimate.time);
    while (frame > 0 && this.time[frame - 1] >= earliest && this.touching(frame - 1) >= 2) --frame;
    return this.count ? Math.min(estimate.time, this.time[frame]) : estimate.time;
  }

  /**
   * Time since which an estimated pose moves with the palm, as of t, or undefined. One from no
   * contacts is that of the resting object (docs/recording-format.md), until two fingers touch.
   */
  carriedSince(estimate, t) {
    if (estimate.contacts.length) return estimate.time;
    const last = this.frameAt(t);
    let frame = this.frameAt(estimate.time);
    while (frame <= last && this.touching(frame) < 2) ++frame;
    return frame <= last ? this.time[frame] : undefined;
  }

  /** Time since which the object is held at t, according to estimates and beliefs. */
  heldFrom(t) {
    const made = this.estimates.filter((estimate) => estimate.time <= t + 1e-3);
    const inHand = this.beliefs.find((belief) => belief.in_hand && belief.time <= t + 1e-3);
    const times = [...made.map((estimate) => this.carriedSince(estimate, t)), inHand?.time];
    const known = times.filter((time) => time !== undefined);
    return known.length ? Math.min(...known) : undefined;
  }

  /** Time from which touches are shown at t: those of the bare table are none of the object. */
  touchesFrom(t) {
    const calibrated = this.phases.findLast((p) => p.name === 'calibrate' && p.begin <= t);
    return calibrated && calibrated.end <= t ? calibrated.end : this.begin;
  }

  /** Fingers that touch in a frame. */
  touching(frame) {
    return this.forces.filter((finger) => finger[frame] > 0).length;
  }

  /** Index of the estimate to draw at time t, or -1. */
  estimateAt(t) {
    const index = this.estimates.findLastIndex((estimate) => estimate.time <= t + 1e-3);
    if (index >= 0 || !this.estimates.length || this.live) return index;
    return t + 1e-3 >= this.heldSince(this.estimates[0]) ? 0 : -1;
  }

  /**
   * Index of the belief to draw at time t, or -1: none once the pose in the hand has been estimated
   * later than it.
   */
  beliefAt(t) {
    const index = this.beliefs.findLastIndex((belief) => belief.time <= t + 1e-3);
    const estimate = this.estimateAt(t);
    if (index < 0 || estimate < 0) return index;
    return this.beliefs[index].time > this.estimates[estimate].time ? index : -1;
  }

  /** Adds the force of each finger in each frame from this one on, N. */
  #addForces(first) {
    const added = this.fingers.map(() => new Float32Array(this.count - first));
    for (let frame = first; frame < this.count; ++frame) {
      for (const contact of this.contacts(frame))
        if (added[contact.finger]) added[contact.finger][frame - first] += Math.max(0, contact.force);
    }
    added.forEach((forces, finger) => this.forceSeries[finger].add(forces));
    this.forces = this.forceSeries.map((forces) => forces.values);
  }

  /** Stretches of time in which the hand touches nothing and no belief changes. */
  deadTimes() {
    if (this.deadOf === this.count) return this.deadFound;
    const busy = this.beliefs.map((belief) => belief.time);
    for (let f = 0; f < this.count; ++f) if (this.touching(f) > 0) busy.push(this.time[f]);
    for (const phase of this.phases) busy.push(phase.begin, phase.end);
    const times = [this.begin, ...busy, this.end].sort((a, b) => a - b);
    const dead = [];
    const skipped = this.phases.filter((phase) => phase.name === 'calibrate');
    for (const phase of skipped) dead.push([phase.begin, phase.end]);
    for (let i = 1; i < times.length; ++i) {
      const from = times[i - 1] + QUIET_MARGIN;
      const to = times[i] - QUIET_MARGIN;
      if (to - from > QUIET_MARGIN && !skipped.some((p) => from >= p.begin && to <= p.end))
        dead.push([from, to]);
    }
    this.deadOf = this.count;
    this.deadFound = dead;
    return dead;
  }
}

const QUIET_MARGIN = 0.4; // s before and after something happens
