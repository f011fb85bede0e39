// SPDX-License-Identifier: Apache-2.0
// Colours that mean something, the same in the view, the time bar and the panel.

export const FINGER_COLORS = ['#e4572e', '#e8a317', '#2fa36b', '#2b8fd6', '#9b5de5'];
export const MODE_COLORS = ['#2f7bf6', '#b04ad8', '#e0457b', '#00a08a', '#7a86ff', '#d0731f'];
const PHASE_COLORS = ['#5b8def', '#3aa981', '#d99a2b', '#a274d8', '#d9688a', '#3fa9bd', '#8b929c'];

/** One colour a phase name, in order of first appearance. */
export function phaseColors(phases) {
  const names = [...new Set(phases.map((phase) => phase.name))];
  return phases.map((phase) => PHASE_COLORS[names.indexOf(phase.name) % PHASE_COLORS.length]);
}

export const modeColor = (i) => MODE_COLORS[i % MODE_COLORS.length];

/** A colour of the page's theme. */
export const theme = (name) =>
  getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

/** Calls back when the system turns dark or light. */
export function onThemeChange(callback) {
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', callback);
}
