// SPDX-License-Identifier: Apache-2.0
// Data of a recording that is still being made (src/recording/page_stream.cpp).

const SHOWN_FOR = 1000; // ms, the largest latency of which is shown

/** Latency from the sending of a frame to its display: the largest of the last second. */
export class Latency {
  constructor() {
    this.recent = [];
  }

  /** @param sent  ms since 1970 of the newest frame that is drawn now */
  add(sent) {
    const now = Date.now();
    this.recent.push([now, now - sent]);
    while (this.recent[0][0] < now - SHOWN_FOR) this.recent.shift();
  }

  get largest() {
    return Math.max(...this.recent.map(([, latency]) => latency));
  }
}

/**
 * Fills the recording with what comes.
 * @param on  {changed(), status(text), ended(text), connected(yes)}
 */
export function connect(recording, on) {
  const source = new EventSource(`events${location.search}`);
  let page;
  const take = {
    page: (id) => {
      if (page !== undefined && page !== id) location.reload();
      page = id;
    },
    frames: (frames) => {
      recording.addFrames(frames);
      recording.sent = frames.sent_ms;
    },
    story: (story) => Object.assign(recording, story),
    estimate: (estimate) => recording.estimates.push(estimate),
    belief: (belief) => recording.addBelief(belief),
    status: on.status,
    end: on.ended,
  };
  source.addEventListener('message', (event) => {
    for (const [kind, content] of Object.entries(JSON.parse(event.data))) take[kind]?.(content);
    on.changed();
  });
  source.addEventListener('open', () => on.connected(true));
  source.addEventListener('error', () => on.connected(false)); // it tries again by itself
}
