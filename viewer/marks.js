// SPDX-License-Identifier: Apache-2.0
// Contacts: a dot at each, and an arrow along the object's normal as long as the force is large.
import * as THREE from 'three';
import { FINGER_COLORS } from './colors.js';

const MOST = 256;
const DOT = 0.0026; // m
const BARE = 0.01; // length of an arrow without force, m
const PER_NEWTON = 0.004; // m
const LONGEST = 0.09; // m
const UP = new THREE.Vector3(0, 1, 0);

function instances(geometry) {
  // Drawn over everything: a contact lies between the finger and the object and would be hidden.
  const material = new THREE.MeshBasicMaterial({ depthTest: false, transparent: true });
  const mesh = new THREE.InstancedMesh(geometry, material, MOST);
  mesh.renderOrder = 10;
  mesh.frustumCulled = false;
  mesh.count = 0;
  return mesh;
}

export class ContactMarks extends THREE.Group {
  constructor() {
    super();
    this.dots = instances(new THREE.SphereGeometry(1, 16, 12));
    this.shafts = instances(new THREE.CylinderGeometry(0.0009, 0.0009, 1, 8).translate(0, 0.5, 0));
    this.heads = instances(new THREE.ConeGeometry(0.0028, 0.007, 12).translate(0, 0.0035, 0));
    this.add(this.dots, this.shafts, this.heads);
  }

  /** @param contacts list of {finger, p, n, force} in this group's frame */
  show(contacts) {
    const color = new THREE.Color();
    const m = new THREE.Matrix4();
    const q = new THREE.Quaternion();
    const shown = contacts.slice(0, MOST);
    shown.forEach((contact, i) => {
      const p = new THREE.Vector3(...contact.p);
      const n = new THREE.Vector3(...contact.n).normalize();
      const length = Math.min(LONGEST, BARE + PER_NEWTON * Math.max(0, contact.force));
      q.setFromUnitVectors(UP, n);
      this.dots.setMatrixAt(i, m.compose(p, q, new THREE.Vector3(DOT, DOT, DOT)));
      this.shafts.setMatrixAt(i, m.compose(p, q, new THREE.Vector3(1, length, 1)));
      this.heads.setMatrixAt(
        i,
        m.compose(p.clone().addScaledVector(n, length), q, new THREE.Vector3(1, 1, 1)),
      );
      color.set(FINGER_COLORS[contact.finger] ?? '#888888');
      for (const mesh of this.children) mesh.setColorAt(i, color);
    });
    for (const mesh of this.children) {
      mesh.count = shown.length;
      mesh.instanceMatrix.needsUpdate = true;
      if (mesh.instanceColor) mesh.instanceColor.needsUpdate = true;
    }
  }
}

/** The contacts an estimate was made from: a small dot and a short stroke along the normal. */
export function evidenceMarks(contacts) {
  const ends = [];
  const colors = [];
  for (const contact of contacts) {
    const color = new THREE.Color(FINGER_COLORS[contact.finger] ?? '#888888');
    for (const reach of [0, 0.012]) {
      ends.push(...contact.p.map((x, i) => x + reach * contact.n[i]));
      colors.push(color.r, color.g, color.b);
    }
  }
  const strokes = new THREE.BufferGeometry();
  strokes.setAttribute('position', new THREE.Float32BufferAttribute(ends, 3));
  strokes.setAttribute('color', new THREE.Float32BufferAttribute(colors, 3));
  const style = { vertexColors: true, depthTest: false, transparent: true, opacity: 0.85 };
  const group = new THREE.Group();
  group.add(new THREE.LineSegments(strokes, new THREE.LineBasicMaterial(style)));
  contacts.forEach((contact, i) => {
    const material = new THREE.MeshBasicMaterial({
      ...style,
      vertexColors: false,
      color: new THREE.Color().fromArray(colors, 6 * i),
    });
    const dot = new THREE.Mesh(new THREE.SphereGeometry(0.0013, 10, 8), material);
    dot.position.fromArray(contact.p);
    group.add(dot);
  });
  group.children.forEach((child) => (child.renderOrder = 9));
  return group;
}
