// SPDX-License-Identifier: Apache-2.0
// Keys of the page. They work wherever the focus is, after a click on a checkbox too.

/** Whether the key belongs to what has the focus: text, or a control that was reached by keys. */
function belongsTo(target, key) {
  if (target.matches?.('input:not([type=checkbox]), textarea')) return true;
  const control = target.closest?.('select, button, input');
  if (!control?.matches(':focus-visible')) return false;
  return key === ' ' || key === 'Enter' || (control.tagName === 'SELECT' && key.startsWith('Arrow'));
}

/** @param actions  by KeyboardEvent.key, letters in lower case */
export function onKeys(actions) {
  document.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || belongsTo(event.target, event.key)) return;
    const action = actions[event.key] ?? actions[event.key.toLowerCase()];
    if (!action) return;
    event.preventDefault();
    action(event);
  });
  // What was clicked keeps no focus: the space bar and the arrows are the clock's.
  document.addEventListener('click', (event) => {
    const control = event.target.closest?.('button, input, select');
    if (event.detail > 0 && control && control.tagName !== 'SELECT') control.blur();
  });
  document.addEventListener('change', (event) => {
    if (event.target.tagName === 'SELECT') event.target.blur();
  });
}
