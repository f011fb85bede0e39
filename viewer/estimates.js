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

/** The credible poses of the resting object: copies in the world, the more probable the more opaque. */
export class PosteriorView extends THREE.Group {
  constructor(posterior, geometry) {
    super();
    for (const { probability, T_world_object } of posterior.poses) {
      const material = new THREE.MeshStandardMaterial({
        color: modeColor(0),
        transparent: true,
        opacity: Math.max(FAINTEST, 0.6 * Math.sqrt(probability)),
        depthWrite: false,
        roughness: 0.8,
      });
      const mesh = new THREE.Mesh(geometry, material);
      mesh.matrix.set(...T_world_object);
      mesh.matrixAutoUpdate = false;
      mesh.renderOrder = 4;
      this.add(mesh);
    }
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
