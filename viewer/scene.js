// SPDX-License-Identifier: Apache-2.0
// The three-dimensional view: table, hand, object, contacts and estimates. z is up, metres.
import * as THREE from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
import { mergeVertices, toCreasedNormals } from 'three/examples/jsm/utils/BufferGeometryUtils.js';
import { onThemeChange, theme } from './colors.js';
import { BeliefView, EstimateView } from './estimates.js';
import { ContactMarks } from './marks.js';
import { PlacementView } from './placement.js';
import { floats, modeShown, POSE, uints } from './recording.js';
import { TouchMarks } from './touches.js';

const VIEWS = {
  corner: [0.62, -0.76, 0.4],
  front: [0, -1.1, 0.1],
  side: [1.1, 0, 0.1],
  top: [0.001, -0.06, 1.2],
};
const CREASE = Math.PI / 5;
const TABLE = 0.45; // half width, m

function meshGeometry(mesh) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(floats(mesh.positions), 3));
  geometry.setIndex(new THREE.BufferAttribute(uints(mesh.indices), 1));
  return toCreasedNormals(mergeVertices(geometry, 1e-6), CREASE);
}

export class Scene {
  /** @param touches  of the recording */
  constructor(element, recording, touches) {
    this.recording = recording;
    this.touches = touches;
    this.element = element;
    this.renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.shadowMap.enabled = true;
    element.prepend(this.renderer.domElement);
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(32, 1, 0.01, 20);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.enableDamping = true;
    this.controls.maxDistance = 4;
    this.controls.minDistance = 0.05;
    this.controls.addEventListener('change', () => this.redraw());
    this.geometries = recording.meshes.map(meshGeometry);
    this.#addLights();
    this.#addTable();
    this.#addHand();
    this.#addObject();
    this.marks = new ContactMarks();
    this.touchMarks = new TouchMarks();
    this.touchMarks.matrixAutoUpdate = false;
    this.scene.add(this.marks, this.touchMarks);
    this.look('corner');
    this.#applyTheme();
    onThemeChange(() => this.#applyTheme());
    new ResizeObserver(() => this.#resize()).observe(element);
    this.#resize();
  }

  #addLights() {
    this.scene.add(new THREE.HemisphereLight('#ffffff', '#8a8378', 1.7));
    const sun = new THREE.DirectionalLight('#ffffff', 2.1);
    sun.position.set(0.5, -0.7, 1.4);
    sun.castShadow = true;
    sun.shadow.mapSize.set(2048, 2048);
    sun.shadow.radius = 5;
    sun.shadow.intensity = 0.6;
    sun.shadow.bias = -0.0004;
    sun.shadow.normalBias = 0.002;
    Object.assign(sun.shadow.camera, {
      left: -0.5,
      right: 0.5,
      top: 0.5,
      bottom: -0.5,
      near: 0.2,
      far: 3,
    });
    const back = new THREE.DirectionalLight('#cfe0ff', 0.7);
    back.position.set(-0.8, 0.9, 0.6);
    this.scene.add(sun, back);
  }

  #addTable() {
    this.table = new THREE.Mesh(
      new THREE.BoxGeometry(2 * TABLE, 2 * TABLE, 0.02),
      // Drawn as if a little farther away than the grid and what stands on it.
      new THREE.MeshStandardMaterial({
        roughness: 0.95,
        polygonOffset: true,
        polygonOffsetFactor: 1,
        polygonOffsetUnits: 8,
      }),
    );
    this.table.position.z = -0.011;
    this.table.receiveShadow = true;
    this.grid = new THREE.GridHelper(2 * TABLE, 18);
    this.grid.rotation.x = Math.PI / 2;
    this.grid.position.z = -0.0005;
    this.grid.material.vertexColors = false;
    this.grid.material.transparent = true;
    this.grid.material.opacity = 0.8;
    const axes = new THREE.AxesHelper(0.05);
    axes.position.set(-TABLE, -TABLE, 0.001);
    this.scene.add(this.table, this.grid, axes);
  }

  #addHand() {
    this.hand = new THREE.Group();
    this.links = [];
    for (let i = 0; i < this.recording.links; ++i) this.links.push(new THREE.Group());
    this.hand.add(...this.links);
    this.handMaterials = new Map();
    for (const part of this.recording.parts) {
      const mesh = new THREE.Mesh(this.geometries[part.mesh], this.#handMaterial(part.color));
      mesh.matrix.set(...part.T_link_mesh);
      mesh.matrixAutoUpdate = false;
      this.#addPart(part.link, mesh);
    }
    for (const sphere of this.recording.spheres) {
      const mesh = new THREE.Mesh(
        new THREE.SphereGeometry(sphere.radius, 20, 14),
        this.#handMaterial([0.5, 0.54, 0.6]),
      );
      mesh.position.fromArray(sphere.center);
      this.#addPart(sphere.link, mesh);
    }
    this.scene.add(this.hand);
  }

  #addPart(link, mesh) {
    mesh.castShadow = mesh.receiveShadow = true;
    this.links[link].add(mesh);
  }

  #handMaterial(rgb) {
    const key = rgb.join();
    if (!this.handMaterials.has(key)) {
      // Lifted from the maker's near-black, so that the form can be read.
      const color = new THREE.Color()
        .setRGB(...rgb, THREE.SRGBColorSpace)
        .lerp(new THREE.Color('#c4ccd6'), 0.35);
      this.handMaterials.set(
        key,
        new THREE.MeshStandardMaterial({ color, roughness: 0.55, metalness: 0.15 }),
      );
    }
    return this.handMaterials.get(key);
  }

  #addObject() {
    const geometry = this.geometries[this.recording.object_mesh];
    // Drawn as if a little farther away than the poses that are believed, which lie in it.
    const style = { polygonOffset: true, polygonOffsetFactor: 3, polygonOffsetUnits: 200 };
    this.object = new THREE.Mesh(
      geometry,
      new THREE.MeshStandardMaterial({ roughness: 0.7, ...style }),
    );
    this.object.castShadow = this.object.receiveShadow = true;
    this.scene.add(this.object);
    const edges = new THREE.EdgesGeometry(geometry, 35);
    this.shape = { geometry, edges };
    this.estimates = [];
    this.belief = new BeliefView(geometry, edges);
    this.scene.add(this.belief);
    this.update();
  }

  /** Takes up what the recording has got since. */
  update() {
    const { geometry, edges } = this.shape;
    for (const estimate of this.recording.estimates.slice(this.estimates.length)) {
      this.estimates.push(new EstimateView(estimate, geometry, edges));
      this.scene.add(this.estimates.at(-1));
    }
    const placement = JSON.stringify(this.recording.placement ?? null);
    if (placement === this.placementShown) return;
    this.placementShown = placement;
    if (this.placement) this.scene.remove(this.placement);
    this.placement = new PlacementView(this.recording.placement, geometry, edges);
    this.scene.add(this.placement);
  }

  #applyTheme() {
    this.scene.background = new THREE.Color(theme('sky'));
    this.table.material.color.set(theme('table'));
    this.grid.material.color.set(theme('grid'));
    this.object.material.color.set(theme('truth'));
    this.redraw();
  }

  #resize() {
    const { clientWidth: width, clientHeight: height } = this.element;
    if (!width || !height) return;
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    // Keeps the width of the scene in view on a tall screen.
    this.camera.fov = this.camera.aspect < 1 ? 32 / Math.max(0.55, this.camera.aspect) : 32;
    this.camera.updateProjectionMatrix();
    this.#draw(); // at once: the new size has emptied the canvas
  }

  /** Looks at the place of the object from one of VIEWS. */
  look(name) {
    const center = this.followed ? this.#handCenter() : this.#objectCenter();
    this.controls.target.copy(center);
    this.camera.position.copy(center).add(new THREE.Vector3(...VIEWS[name]));
    this.controls.update();
    this.redraw();
  }

  /** Where the object stood at first, and some way up. */
  #objectCenter() {
    const center = new THREE.Vector3(0, 0, 0.19);
    const r = this.recording;
    if (r.count && r.hasObject[0]) [center.x, center.y] = r.objectPoses;
    else if (r.live && r.count) center.copy(this.#handCenter());
    return center;
  }

  #handCenter() {
    return this.links[this.recording.palm]?.position.clone() ?? new THREE.Vector3(0, 0, 0.19);
  }

  /** The camera goes along with the hand, or stays. */
  follow(on) {
    this.followed = on ? this.#handCenter() : undefined;
  }

  #moveAlong() {
    if (!this.followed) return;
    const center = this.#handCenter();
    const way = center.clone().sub(this.followed);
    this.camera.position.add(way);
    this.controls.target.add(way);
    this.followed = center;
  }

  #setSeeThrough(on) {
    if (this.seeThrough === on) return;
    this.seeThrough = on;
    for (const material of this.handMaterials.values()) {
      material.transparent = on;
      material.depthWrite = !on;
      material.opacity = on ? 0.25 : 1;
      material.needsUpdate = true;
    }
    this.hand.traverse((child) => (child.castShadow = !on));
  }

  /** Moves everything to time t. @param shown what the panel has switched on */
  show(t, shown) {
    if (this.recording.count) this.#place(t, shown);
    this.hand.visible = shown.hand;
    this.#setSeeThrough(shown.seeThrough);
    this.redraw();
  }

  #place(t, shown) {
    const r = this.recording;
    const { frame, share } = r.between(t);
    this.links.forEach((link, i) => this.#pose(link, r.linkPoses, r.links, i, frame, share));
    this.#moveAlong();
    this.object.visible = shown.truth && r.hasObject[frame] > 0;
    const smooth = share > 0 && r.hasObject[frame + 1] > 0;
    this.#pose(this.object, r.objectPoses, 1, 0, frame, smooth ? share : 0);
    this.marks.visible = shown.contacts;
    this.marks.show(r.contacts(frame));
    const believed = r.beliefAt(t);
    this.belief.visible = shown.estimate && believed >= 0;
    if (this.belief.visible) this.#placeBelief(r.beliefs[believed], t);
    const current = believed < 0 ? r.estimateAt(t) : -1;
    this.estimates.forEach((view, i) => {
      view.visible = i === current;
      if (view.visible) this.#placeEstimate(view, r.estimates[i], t, shown);
    });
    this.#placeTouches(t, shown);
  }

  #placeBelief(belief, t) {
    this.belief.show(belief);
    this.#carry(this.belief, belief.in_hand ? belief.time : undefined, t);
  }

  /** Touches stay where they were sensed; those until the object is held go with the palm then. */
  #placeTouches(t, shown) {
    const r = this.recording;
    const held = r.heldFrom(t);
    this.touchMarks.visible = shown.touches;
    this.touchMarks.show(this.touches.list, r.touchesFrom(t), Math.min(t, held ?? t));
    this.#carry(this.touchMarks, held, t);
  }

  #placeEstimate(view, estimate, t, shown) {
    this.#carry(view, this.recording.carriedSince(estimate, t), t);
    view.modes.forEach(
      (mode, i) => (mode.visible = shown.estimate && modeShown(shown, estimate, i)),
    );
    view.evidence.visible = shown.evidence;
  }

  /** Moves what was found of the object as the palm has moved since a time; undefined: it rests. */
  #carry(view, since, t) {
    view.matrix.identity();
    if (since === undefined) return;
    // Once the hand has let go, the object stays where it stood then.
    const letGo = this.recording.placement?.let_go.find((at) => at > since - 1e-3) ?? Infinity;
    view.matrix.copy(this.#palmAt(Math.min(t, letGo))).multiply(this.#palmAt(since).invert());
  }

  /** The palm's pose in the world. */
  #palmAt(t) {
    const r = this.recording;
    const { frame, share } = r.between(t);
    const palm = new THREE.Group();
    this.#pose(palm, r.linkPoses, r.links, r.palm, frame, share);
    palm.updateMatrix();
    return palm.matrix;
  }

  #pose(target, values, stride, index, frame, share) {
    const at = (f) => (f * stride + index) * POSE;
    target.position.fromArray(values, at(frame));
    target.quaternion.fromArray(values, at(frame) + 3);
    if (share > 0) {
      target.position.lerp(new THREE.Vector3().fromArray(values, at(frame + 1)), share);
      target.quaternion.slerp(new THREE.Quaternion().fromArray(values, at(frame + 1) + 3), share);
    }
  }

  /** Draws at the next opportunity; nothing is drawn while nothing changes. */
  redraw() {
    this.pending ??= requestAnimationFrame(() => {
      this.pending = undefined;
      this.#draw();
    });
  }

  #draw() {
    this.controls.update();
    this.renderer.render(this.scene, this.camera);
    this.onDrawn?.(this.renderer.domElement);
  }
}
