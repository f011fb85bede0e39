# SPDX-License-Identifier: Apache-2.0
"""Steps a second of Palpate/Relocate-v2: vectors of it on C++ threads beside gymnasium's own.

usage: relocate_environments.py [ENVIRONMENTS [STEPS [REPEATS [SOLVER]]]]

Every way steps the same model by the same actions. They take turns, so that what else the machine
does falls on all of them; beside the wall time stands the processor time of all processes.
"""

import os
import statistics
import sys
import time

import gymnasium
import numpy as np
import palpate.envs  # noqa: F401

GIVEN = sys.argv[1:] + ["2", "200", "5", "faithful"][len(sys.argv) - 1 :]
ENVIRONMENTS, STEPS, REPEATS = map(int, GIVEN[:3])
NAME, TASK = "Palpate/Relocate-v2", {"horizon": 100000, "solver": GIVEN[3]}
WAYS = {
    "C++, 1 thread": {"vectorization_mode": "vector_entry_point", "threads": 1},
    "C++, 2 threads": {"vectorization_mode": "vector_entry_point", "threads": 2},
    "gymnasium, one after the other": {"vectorization_mode": "sync"},
    "gymnasium, a process each": {"vectorization_mode": "async"},
}


def processor_seconds():
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


def run(settings):
    """Wall and processor seconds of the steps; processes are counted once they have ended."""
    settings = dict(settings)
    actions = np.random.default_rng(1).uniform(-0.3, 0.3, (STEPS, ENVIRONMENTS, 30))
    actions[:, :, 2:4] = 0.1, 0.4  # the palm towards the object
    env = gymnasium.make_vec(NAME, ENVIRONMENTS, **settings, **TASK)
    env.reset(seed=1)
    before, begin = processor_seconds(), time.perf_counter()
    touching = 0
    for action in actions:
        *_, infos = env.step(action)
        touching += infos["contact"].mean() / STEPS
    wall = time.perf_counter() - begin
    env.close()
    return wall, processor_seconds() - before, touching


rows = {name: [] for name in WAYS}
for _ in range(REPEATS):
    for name, settings in WAYS.items():
        rows[name].append(run(settings))
steps = ENVIRONMENTS * STEPS
print(f"{ENVIRONMENTS} environments, {STEPS} steps each, {REPEATS} times, solver {GIVEN[3]}; medians")
for name, times in rows.items():
    wall, processor, touching = [statistics.median(column) for column in zip(*times)]
    print(f"{name:32} {steps / wall:7.0f} steps/s, {1e6 * processor / steps:6.0f} us of a processor "
          f"a step, hand and object touch in {touching:.0%}")  # fmt: skip
