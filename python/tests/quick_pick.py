# SPDX-License-Identifier: Apache-2.0
"""Options of picks in an ideal world that take seconds, for the tests of palpate.sim."""

try:
    from palpate import sim
except ImportError:
    sim = None

IDEAL = sim.IDEAL if sim else {}
QUICK = IDEAL | {
    "calibrate.touches": 4, "explore.touches": 2, "explore.max_touches": 2, "attempts": 1,
    "estimation.search.proposals": 20000, "estimation.search.particles": 400,
}  # fmt: skip
