// SPDX-License-Identifier: Apache-2.0
// The page: a clock that moves the scene, the time bar, the plots and the panel.
import { Film, filmKinds } from './film.js';
import { onKeys } from './keys.js';
import { connect, Latency } from './live.js';
import { Panel } from './panel.js';
import { Plots } from './plots.js';
import { phaseLabel, Recording } from './recording.js';
import { Scene } from './scene.js';
import { Timeline } from './timeline.js';
import { Touches } from './touches.js';

const byId = (id) => document.getElementById(id);
const recording = new Recording(JSON.parse(byId('recording').textContent));
const touches = new Touches(recording);
const shown = {
  hand: true,
  seeThrough: false,
  truth: false,
  estimate: true,
  contacts: true,
  touches: true,
  evidence: false,
  follow: false,
  skip: false,
  modes: {},
};
const play = byId('play');
const speed = byId('speed');
const compared = window.parent !== window; // beside another page

let now = recording.begin;
let playing = false;
let last;
let atEdge = Boolean(recording.live); // shows what has come last
let leads = !compared; // of two pages beside one another: the one that was moved last

/** The scene, or nothing where the browser cannot draw in 3D: the rest still works. */
function makeScene() {
  try {
    return new Scene(byId('view'), recording, touches);
  } catch (error) {
    byId('message').hidden = false;
    byId('message').textContent = `This browser cannot show the 3D view (${error.message}).`;
    return undefined;
  }
}

touches.update();
const scene = makeScene();
const timeline = new Timeline(byId('timeline'), recording, seekByHand);
const plots = new Plots(byId('plots'), recording);
const panel = new Panel(recording, document.title, shown, { seek: seekByHand, changed });
const film = new Film('palpate', () => byId('caption').innerText.split('\n'));
window.palpate = { recording, scene }; // for scripts
if (scene) scene.onDrawn = (view) => film.running && film.picture(view);

function changed() {
  showLayers();
  if (compared) window.parent.postMessage({ shown: layers() }, '*');
}

function showLayers() {
  scene?.follow(shown.follow);
  show();
}

/** What is switched on, but for the modes, which are of this recording alone. */
function layers() {
  return Object.fromEntries(Object.entries(shown).filter(([, on]) => typeof on === 'boolean'));
}

/** Takes up what was switched on or off beside. */
function takeLayers(given) {
  for (const key of Object.keys(layers())) if (typeof given[key] === 'boolean') shown[key] = given[key];
  panel.showLayers();
  showLayers();
}

function show() {
  scene?.show(now, shown);
  timeline.show(now);
  plots.show(now, shown.truth);
  panel.show(now);
  const phase = recording.phases[recording.phaseAt(now)];
  const [name, outcome] = byId('caption').children;
  name.textContent = phaseLabel(phase?.name ?? '');
  outcome.textContent = phase && now >= phase.end - 0.02 ? phase.outcome.replace(/^ok: /, '') : '';
  const clock = document.createElement('small');
  clock.textContent = ` / ${recording.end.toFixed(2)} s`;
  byId('clock').replaceChildren(now.toFixed(2), clock);
  if (compared && leads) window.parent.postMessage({ time: now - recording.begin }, '*');
}

function seek(t) {
  now = Math.min(recording.end, Math.max(recording.begin, t));
  show();
}

function seekByHand(t) {
  leads = true;
  setAtEdge(false);
  seek(t);
}

function setAtEdge(on) {
  atEdge = on && Boolean(recording.live);
  byId('live').classList.toggle('on', atEdge);
  if (atEdge) seek(recording.end);
}

function setPlaying(on) {
  if (on && now >= recording.end - 1e-6 && !recording.live) now = recording.begin;
  playing = on;
  last = undefined;
  leads = leads || on;
  play.textContent = on ? 'Pause' : 'Play';
  if (on) requestAnimationFrame(tick);
  else film.stop();
}

/** Where the clock goes on from t: past a stretch in which nothing happens, if that is wanted. */
function skipped(t) {
  const dead = shown.skip && recording.deadTimes().find(([from, to]) => t > from && t < to);
  return dead ? dead[1] : t;
}

function tick(stamp) {
  if (!playing) return;
  const passed = last === undefined ? 0 : Math.min(0.1, (stamp - last) / 1000);
  last = stamp;
  seek(skipped(now + passed * Number(speed.value)));
  if (now < recording.end) requestAnimationFrame(tick);
  else {
    setPlaying(false);
    setAtEdge(true);
  }
}

function changeSpeed(by) {
  speed.selectedIndex = Math.min(speed.options.length - 1, Math.max(0, speed.selectedIndex + by));
}

function toPhase(by) {
  const begins = recording.phases.map((phase) => phase.begin);
  const target =
    by > 0 ? begins.find((t) => t > now + 0.05) : begins.findLast((t) => t < now - 0.05);
  seekByHand(target ?? (by > 0 ? recording.end : recording.begin));
}

function toggle(key) {
  shown[key] = !shown[key];
  panel.showLayers();
  changed();
}

function togglePlaying() {
  setAtEdge(false);
  setPlaying(!playing);
}

function toggleFilm() {
  if (film.running) {
    film.stop();
    setPlaying(false);
  } else if (scene) {
    film.start(scene.renderer.domElement);
    setPlaying(true);
  }
}

onKeys({
  ' ': togglePlaying,
  ArrowLeft: (event) => seekByHand(now - (event.shiftKey ? 1 : 0.1)),
  ArrowRight: (event) => seekByHand(now + (event.shiftKey ? 1 : 0.1)),
  ArrowUp: () => changeSpeed(1),
  ArrowDown: () => changeSpeed(-1),
  Home: () => seekByHand(recording.begin),
  End: () => seekByHand(recording.end),
  PageDown: () => toPhase(1),
  PageUp: () => toPhase(-1),
  n: () => toPhase(1),
  p: () => toPhase(-1),
  t: () => toggle('truth'),
  f: () => toggle('follow'),
  d: () => toggle('skip'),
  h: () => toggle('seeThrough'),
  l: () => setAtEdge(true),
});

/** Value of a key in an address like #t=3.2&view=side. */
function inAddress(key) {
  return new URLSearchParams(location.hash.slice(1)).get(key);
}

function timeInAddress() {
  const t = inAddress('t');
  if (t === 'end') return recording.end;
  return t === null || Number.isNaN(Number(t)) ? undefined : Number(t);
}

/** What the address asks for besides the time. */
function lookAsAddressed() {
  const view = inAddress('view');
  if (document.querySelector(`[data-view="${CSS.escape(view ?? '')}"]`)) scene?.look(view);
  const show = inAddress('show')?.split(',') ?? [];
  for (const key of show) if (typeof shown[key] === 'boolean') shown[key] = true;
  panel.showLayers();
}

function seekAddress() {
  lookAsAddressed();
  const t = timeInAddress();
  if (t === undefined) return;
  setPlaying(false);
  setAtEdge(false);
  seek(t);
}

/** Takes up what has come, once a picture. */
function watch() {
  const latency = new Latency();
  let words = '';
  let pending;
  const draw = () => {
    pending = undefined;
    touches.update();
    scene?.update();
    panel.update();
    if (recording.sent !== undefined) latency.add(recording.sent);
    recording.sent = undefined;
    if (atEdge) seek(recording.end);
    else show();
    tell();
  };
  const tell = () => {
    const parts = [Number.isFinite(latency.largest) ? `${Math.round(latency.largest)} ms behind` : '', words];
    byId('status').textContent = parts.filter(Boolean).join(' · ');
  };
  byId('live').hidden = false;
  connect(recording, {
    changed: () => (pending ??= requestAnimationFrame(draw)),
    status: (text) => (words = text),
    ended: (text) => {
      words = text;
      byId('live').classList.add('ended');
    },
    connected: (yes) => byId('live').classList.toggle('lost', !yes),
  });
}

play.addEventListener('click', togglePlaying);
byId('live').addEventListener('click', () => setAtEdge(true));
byId('film').addEventListener('click', toggleFilm);
byId('film').hidden = !filmKinds().length || !scene;
addEventListener('hashchange', seekAddress);
addEventListener('message', (event) => {
  if (!compared || event.source !== window.parent) return;
  if (event.data?.shown) takeLayers(event.data.shown);
  if (!Number.isFinite(event.data?.time)) return;
  leads = false;
  if (playing) setPlaying(false);
  seek(recording.begin + event.data.time);
});
for (const button of document.querySelectorAll('[data-view]')) {
  button.addEventListener('click', () => scene?.look(button.dataset.view));
}

/**
 * The calibration on the bare table is long and shows nothing of the object. Two recordings begin at
 * the same time.
 */
function firstOfInterest() {
  const first = recording.phases[0];
  return !compared && first?.name === 'calibrate' ? first.end : recording.begin;
}

if (compared) shown.skip = false;
lookAsAddressed();
seek(timeInAddress() ?? firstOfInterest());
const still = matchMedia('(prefers-reduced-motion: reduce)').matches;
if (recording.live) {
  watch();
  setAtEdge(true);
} else if (timeInAddress() === undefined && !still && !compared) setPlaying(true);
