// SPDX-License-Identifier: Apache-2.0
// An estimate's modes as see-through copies of the object, the heavier the more opaque.
import * as THREE from 'three';
import { modeColor } from './colors.js';
import { evidenceMarks } from './marks.js';

function ghost(geometry, edges, mode, i) {
  const color = modeColor(i);
  const fill = new THREE.MeshStandardMaterial({
    color,
    transparent: true,
    opacity: 0.1 + 0.4 * mode.weight,
    depthWrite: false,
    roughness: 0.8,
    polygonOffset: true,
    polygonOffsetFactor: -1,
    polygonOffsetUnits: -4,
  });
  // Outlines show through everything, so that a pose inside the hand or the true object is seen.
  const stroke = new THREE.LineBasicMaterial({
    color,
    transparent: true,
    opacity: 0.25 + 0.6 * mode.weight,
    depthTest: false,
  });
  const group = new THREE.Group();
  group.add(new THREE.Mesh(geometry, fill), new THREE.LineSegments(edges, stroke));
  group.matrix.set(...mode.T_world_object);
  group.matrixAutoUpdate = false;
  if (mode.free_axis) group.userData.axis = mode.free_axis;
  group.children.forEach((child) => (child.renderOrder = 5 - 0.1 * i));
  return group;
}

function axisLine(axis, i) {
  const d = new THREE.Vector3(...axis.direction).multiplyScalar(0.15);
  const p = new THREE.Vector3(...axis.point);
  const geometry = new THREE.BufferGeometry().setFromPoints([p.clone().sub(d), p.clone().add(d)]);
  const material = new THREE.LineDashedMaterial({
    color: modeColor(i),
    dashSize: 0.008,
    gapSize: 0.006,
  });
  return new THREE.Line(geometry, material).computeLineDistances();
}

const FAINTEST = 0.05; // opacity
const GHOSTS = 64; // at most

/** A belief: copies of the object at its credible poses, the more probable the more opaque. */
export class BeliefView extends THREE.Group {
  constructor(geometry, edges) {
    super();
    this.matrixAutoUpdate = false;
    for (let i = 0; i < GHOSTS; ++i) this.add(BeliefView.#ghost(geometry, edges));
  }

  static #ghost(geometry, edges) {
    const fill = new THREE.MeshStandardMaterial({
      color: modeColor(0),
      transparent: true,
      depthWrite: false,
      roughness: 0.8,
      polygonOffset: true,
      polygonOffsetFactor: -1,
      polygonOffsetUnits: -4,
    });
    const stroke = new THREE.LineBasicMaterial({ color: modeColor(0), transparent: true });
    const ghost = new THREE.Group();
    ghost.add(new THREE.Mesh(geometry, fill), new THREE.LineSegments(edges, stroke));
    ghost.children.forEach((child) => (child.renderOrder = 4));
    ghost.matrixAutoUpdate = false;
    ghost.visible = false;
    return ghost;
  }

  /** Shows a belief, in the world as it was then. */
  show(belief) {
    if (belief === this.shown) return;
    this.shown = belief;
    this.children.forEach((ghost, i) => {
      const pose = belief.poses[i];
      ghost.visible = pose !== undefined && pose.probability > 0;
      if (!ghost.visible) return;
      ghost.matrix.set(...pose.T_world_object);
      const [fill, stroke] = ghost.children;
      fill.material.opacity = Math.max(FAINTEST, 0.6 * pose.probability ** 0.7);
      stroke.material.opacity = Math.max(FAINTEST, 0.8 * pose.probability);
    });
  }
}

/** One estimate: a group in the world as it was when the estimate was made. */
export class EstimateView extends THREE.Group {
  constructor(estimate, geometry, edges) {
    super();
    this.modes = estimate.modes.map((mode, i) => {
      const group = new THREE.Group();
      group.add(ghost(geometry, edges, mode, i));
      if (mode.free_axis) group.add(axisLine(mode.free_axis, i));
      this.add(group);
      return group;
    });
    this.evidence = evidenceMarks(estimate.contacts);
    this.add(this.evidence);
    this.matrixAutoUpdate = false;
  }
}
