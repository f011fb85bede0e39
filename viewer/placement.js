// SPDX-License-Identifier: Apache-2.0
// Where the object is to be put: an outline of it at the target, the way planned there, and the
// fixture.
import * as THREE from 'three';

const TARGET_COLOR = '#1f9d55';
const FIXTURE_COLOR = '#9aa3ad';

function targetGhost(pose, geometry, edges) {
  const fill = new THREE.MeshStandardMaterial({
    color: TARGET_COLOR,
    transparent: true,
    opacity: 0.18,
    depthWrite: false,
  });
  const stroke = new THREE.LineBasicMaterial({
    color: TARGET_COLOR,
    transparent: true,
    opacity: 0.8,
  });
  const group = new THREE.Group();
  group.add(new THREE.Mesh(geometry, fill), new THREE.LineSegments(edges, stroke));
  group.matrix.set(...pose);
  group.matrixAutoUpdate = false;
  return group;
}

function plannedPath(values) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.Float32BufferAttribute(values, 3));
  return new THREE.Line(geometry, new THREE.LineBasicMaterial({ color: TARGET_COLOR }));
}

function fixtureBox(values) {
  const [x, y, z] = values.slice(16);
  const box = new THREE.Mesh(
    new THREE.BoxGeometry(2 * x, 2 * y, 2 * z),
    new THREE.MeshStandardMaterial({ color: FIXTURE_COLOR, roughness: 0.8 }),
  );
  box.matrix.set(...values.slice(0, 16));
  box.matrixAutoUpdate = false;
  box.castShadow = box.receiveShadow = true;
  return box;
}

/** Target, planned way and fixture of a recording; empty for a pick without placing. */
export class PlacementView extends THREE.Group {
  constructor(placement, geometry, edges) {
    super();
    if (placement?.target) this.add(targetGhost(placement.target, geometry, edges));
    if (placement?.path?.length) this.add(plannedPath(placement.path));
    for (const box of placement?.fixture ?? []) this.add(fixtureBox(box));
  }
}
