// SPDX-License-Identifier: Apache-2.0
// The replay page: a clock that moves the scene, the time bar and the panel.
import { Panel } from './panel.js';
import { phaseLabel, Recording } from './recording.js';
import { Scene } from './scene.js';
import { Timeline } from './timeline.js';

const byId = (id) => document.getElementById(id);
const recording = new Recording(JSON.parse(byId('recording').textContent));
const shown = {
  hand: true,
  seeThrough: false,
  truth: true,
  estimate: true,
  contacts: true,
  evidence: false,
  modes: {},
};
const play = byId('play');
const speed = byId('speed');

let now = recording.begin;
let playing = false;
let last;

/** The scene, or nothing where the browser cannot draw in 3D: the rest still works. */
function makeScene() {
  try {
    return new Scene(byId('view'), recording);
  } catch (error) {
    byId('message').hidden = false;
    byId('message').textContent = `This browser cannot show the 3D view (${error.message}).`;
    return undefined;
  }
}

const scene = makeScene();
const timeline = new Timeline(byId('timeline'), recording, seek);
const panel = new Panel(recording, document.title, shown, {
  seek,
  changed: () => scene?.show(now, shown),
});

function show() {
  scene?.show(now, shown);
  timeline.show(now);
  panel.show(now);
  const phase = recording.phases[recording.phaseAt(now)];
  const [name, outcome] = byId('caption').children;
  name.textContent = phaseLabel(phase?.name ?? '');
  outcome.textContent = phase && now >= phase.end - 0.02 ? phase.outcome.replace(/^ok: /, '') : '';
  const clock = document.createElement('small');
  clock.textContent = ` / ${recording.end.toFixed(2)} s`;
  byId('clock').replaceChildren(now.toFixed(2), clock);
}

function seek(t) {
  now = Math.min(recording.end, Math.max(recording.begin, t));
  show();
}

function setPlaying(on) {
  if (on && now >= recording.end - 1e-6) now = recording.begin;
  playing = on;
  last = undefined;
  play.textContent = on ? 'Pause' : 'Play';
  if (on) requestAnimationFrame(tick);
}

function tick(stamp) {
  if (!playing) return;
  const passed = last === undefined ? 0 : Math.min(0.1, (stamp - last) / 1000);
  last = stamp;
  seek(now + passed * Number(speed.value));
  if (now >= recording.end) setPlaying(false);
  else requestAnimationFrame(tick);
}

function changeSpeed(by) {
  speed.selectedIndex = Math.min(speed.options.length - 1, Math.max(0, speed.selectedIndex + by));
}

function onKey(event) {
  if (event.target.closest?.('select, input') || event.ctrlKey || event.metaKey || event.altKey)
    return;
  const step = event.shiftKey ? 1 : 0.1;
  const actions = {
    ' ': () => setPlaying(!playing),
    ArrowLeft: () => seek(now - step),
    ArrowRight: () => seek(now + step),
    ArrowUp: () => changeSpeed(1),
    ArrowDown: () => changeSpeed(-1),
    Home: () => seek(recording.begin),
    End: () => seek(recording.end),
  };
  if (!actions[event.key]) return;
  event.preventDefault();
  actions[event.key]();
}

/** Value of a key in an address like #t=3.2&view=side. */
function inAddress(key) {
  return new URLSearchParams(location.hash.slice(1)).get(key);
}

function timeInAddress() {
  const t = inAddress('t');
  return t === null || Number.isNaN(Number(t)) ? undefined : Number(t);
}

function lookAsAddressed() {
  const view = inAddress('view');
  if (document.querySelector(`[data-view="${CSS.escape(view ?? '')}"]`)) scene?.look(view);
}

function seekAddress() {
  lookAsAddressed();
  const t = timeInAddress();
  if (t === undefined) return;
  setPlaying(false);
  seek(t);
}

play.addEventListener('click', () => setPlaying(!playing));
document.addEventListener('keydown', onKey);
// A focused button would take the space bar for a click as well.
document.addEventListener(
  'keyup',
  (event) => event.key === ' ' && event.target.closest?.('button') && event.preventDefault(),
);
addEventListener('hashchange', seekAddress);
for (const button of document.querySelectorAll('[data-view]')) {
  button.addEventListener('click', () => scene?.look(button.dataset.view));
}
/** The calibration on the bare table is long and shows nothing of the object. */
function firstOfInterest() {
  const first = recording.phases[0];
  return first?.name === 'calibrate' ? first.end : recording.begin;
}

lookAsAddressed();
seek(timeInAddress() ?? firstOfInterest());
if (timeInAddress() === undefined && !matchMedia('(prefers-reduced-motion: reduce)').matches)
  setPlaying(true);
