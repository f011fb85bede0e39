// SPDX-License-Identifier: Apache-2.0
// Where the fingers have touched: marks that stay.
import * as THREE from 'three';
import { FINGER_COLORS } from './colors.js';

const MOST = 400;
const DOT = 0.0022; // m
const APART = 0.003; // m, from the last mark of the same touch
const UP = new THREE.Vector3(0, 1, 0);

/**
 * Touches of a recording, one by one: when, by which finger, where and which way the surface faces.
 * Found once a frame, as the recording grows.
 */
export class Touches {
  constructor(recording) {
    this.recording = recording;
    this.reset();
  }

  reset() {
    this.list = [];
    this.frames = 0;
    this.last = this.recording.fingers.map(() => undefined);
  }

  update() {
    const r = this.recording;
    if (this.frames > r.count) this.reset(); // older frames were dropped
    for (; this.frames < r.count; ++this.frames) this.#add(this.frames);
  }

  #add(frame) {
    const touched = new Set();
    for (const contact of this.recording.contacts(frame)) {
      touched.add(contact.finger);
      const p = Float32Array.from(contact.p);
      const last = this.last[contact.finger];
      if (last && Math.hypot(p[0] - last[0], p[1] - last[1], p[2] - last[2]) < APART) continue;
      this.last[contact.finger] = p;
      this.list.push({
        time: this.recording.time[frame],
        finger: contact.finger,
        p,
        n: Float32Array.from(contact.n),
      });
    }
    this.last.forEach((_, finger) => {
      if (!touched.has(finger)) this.last[finger] = undefined;
    });
  }
}

export class TouchMarks extends THREE.InstancedMesh {
  constructor() {
    // A disc on the surface, drawn over what hides it.
    const disc = new THREE.CylinderGeometry(1, 1, 0.25, 16);
    const style = { depthTest: false, transparent: true, opacity: 0.75 };
    super(disc, new THREE.MeshBasicMaterial(style), MOST);
    this.renderOrder = 8;
    this.frustumCulled = false;
    this.count = 0;
  }

  /** The marks of the last touches between two times. */
  show(list, from, to) {
    const shown = list.filter((touch) => touch.time >= from && touch.time <= to).slice(-MOST);
    const key = `${shown.length} ${shown[0]?.time} ${shown.at(-1)?.time}`;
    if (key === this.shownKey) return;
    this.shownKey = key;
    const [m, q, color] = [new THREE.Matrix4(), new THREE.Quaternion(), new THREE.Color()];
    shown.forEach((touch, i) => {
      q.setFromUnitVectors(UP, new THREE.Vector3(...touch.n).normalize());
      this.setMatrixAt(i, m.compose(new THREE.Vector3(...touch.p), q, new THREE.Vector3(DOT, DOT, DOT)));
      this.setColorAt(i, color.set(FINGER_COLORS[touch.finger] ?? '#888888'));
    });
    this.count = shown.length;
    this.instanceMatrix.needsUpdate = true;
    if (this.instanceColor) this.instanceColor.needsUpdate = true;
  }
}
