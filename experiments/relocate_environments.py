# SPDX-License-Identifier: Apache-2.0
"""Steps a second of Palpate/Relocate-v2: vectors of it on C++ threads beside gymnasium's own.

usage: relocate_environments.py [ENVIRONMENTS [STEPS [REPEATS [SOLVER]]]]

Every way steps the same model by the same actions. They take turns, so that what else the machine
does falls on all of them; beside the wall time stands the processor time of all processes. In the
last way each thread of Python steps a vector of its own, and neither waits for the other.
"""

import concurrent.futures
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


def drawn_actions():
    actions = np.random.default_rng(1).uniform(-0.3, 0.3, (STEPS, ENVIRONMENTS, 30))
    actions[:, :, 2:4] = 0.1, 0.4  # the palm towards the object
    return actions


def step_all(env, actions):
    """The share of steps in which hand and object touch."""
    touching = 0
    for action in actions:
        *_, infos = env.step(action)
        touching += infos["contact"].mean() / len(actions)
    return touching


def run(settings):
    """Wall and processor seconds of the steps; processes are counted once they have ended."""
    actions, env = drawn_actions(), gymnasium.make_vec(NAME, ENVIRONMENTS, **settings, **TASK)
    env.reset(seed=1)
    before, begin = processor_seconds(), time.perf_counter()
    touching = step_all(env, actions)
    wall = time.perf_counter() - begin
    env.close()
    return wall, processor_seconds() - before, touching


def run_apart(settings):
    """The same with a vector of its own, and a half of the environments, for each of 2 threads."""
    half = ENVIRONMENTS // 2
    envs = [gymnasium.make_vec(NAME, half, **settings, **TASK) for _ in range(2)]
    for index, env in enumerate(envs):
        env.reset(seed=1 + index * half)
    halves = drawn_actions()[:, :half], drawn_actions()[:, half:]
    before, begin = processor_seconds(), time.perf_counter()
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        touching = list(pool.map(step_all, envs, halves))
    return time.perf_counter() - begin, processor_seconds() - before, sum(touching) / 2


APART = "C++, 2 threads that do not wait"
rows = {name: [] for name in (*WAYS, APART)}
for _ in range(REPEATS):
    for name, settings in WAYS.items():
        rows[name].append(run(settings))
    rows[APART].append(run_apart(WAYS["C++, 1 thread"]))
steps = ENVIRONMENTS * STEPS
print(f"{ENVIRONMENTS} environments, {STEPS} steps each, {REPEATS} times, solver {GIVEN[3]}; medians")
for name, times in rows.items():
    wall, processor, touching = [statistics.median(column) for column in zip(*times)]
    print(f"{name:32} {steps / wall:7.0f} steps/s, {1e6 * processor / steps:6.0f} us of a processor "
          f"a step, hand and object touch in {touching:.0%}")  # fmt: skip
