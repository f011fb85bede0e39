# SPDX-License-Identifier: Apache-2.0
"""Steps a second of palpate's relocate task and of gymnasium-robotics', in one run.

usage: relocate_peers.py PALPATE POLICY [--episodes N] [--rounds R]

POLICY is a network on the 39 observations: of kind "mlp", as `palpate train relocate` makes it with
`--method dagger`, or DexMV's published one (W0, b0, ...). It drives all, for 99 steps an episode.
The peer relocates its own ball, put where the mug starts, and in a second environment a mug of as
many parts as palpate's, with the peer's own solver.
Rounds alternate, and the medians are compared. Times are processor time on one thread, so that
other work on the machine counts against nobody, and elapsed time: on one thread for the peer, on
two for palpate. Only on an idle machine does elapsed time mean anything.
"""

import argparse
import json
import math
import resource
import statistics
import subprocess
import time

import gymnasium
import gymnasium_robotics
import mujoco
import numpy as np

STEPS = 99


DEXMV_SCALE_FLOOR = 1e-8  # that DexMV adds to the scale of the inputs


class Network:
    def __init__(self, path):
        record = json.load(open(path))
        if "W0" in record:
            self.read_dexmv(record)
        else:
            self.read_own(path, record)

    def read_dexmv(self, record):
        self.layers = [(np.array(record[f"W{i}"]), np.array(record[f"b{i}"])) for i in range(3)]
        self.arrays = {
            "input_shift": np.array(record["in_shift"]),
            "input_scale": np.array(record["in_scale"]) + DEXMV_SCALE_FLOOR,
            "output_shift": np.array(record["out_shift"]),
            "output_scale": np.array(record["out_scale"]),
        }

    def read_own(self, path, record):
        if record.get("kind") != "mlp":
            raise SystemExit(f"{path}: a policy of kind {record.get('kind')}, not mlp")
        arrays = {name: np.array(values) for name, values in record["arrays"].items()}
        self.arrays, self.layers, parameters = arrays, [], arrays["parameters"]
        for inputs, outputs in zip(record["sizes"], record["sizes"][1:]):
            weights, parameters = np.split(parameters, [inputs * outputs])
            bias, parameters = np.split(parameters, [outputs])
            self.layers.append((weights.reshape(inputs, outputs).T, bias))

    def __call__(self, observation):
        a = self.arrays
        x = (observation - a["input_shift"]) / a["input_scale"]
        for weights, bias in self.layers[:-1]:
            x = np.tanh(weights @ x + bias)
        weights, bias = self.layers[-1]
        return np.clip(a["output_shift"] + a["output_scale"] * (weights @ x + bias), -1, 1)


def mug_parts():
    """Type, half sizes, position and turn about z (rad) of a ring of 12 boxes, a floor, a handle."""
    sides, radius = 12, 0.0350
    for i in range(sides):
        angle = 2 * math.pi * i / sides
        position = [radius * math.cos(angle), radius * math.sin(angle), 0]
        width = radius * math.tan(math.pi / sides)
        yield mujoco.mjtGeom.mjGEOM_BOX, [0.0015, width, 0.0325], position, angle
    yield mujoco.mjtGeom.mjGEOM_CYLINDER, [0.034, 0.0016, 0], [0, 0, -0.0310], 0
    yield mujoco.mjtGeom.mjGEOM_BOX, [0.0092, 0.005, 0.0034], [0.0388, 0, 0.0202], 0
    yield mujoco.mjtGeom.mjGEOM_BOX, [0.0034, 0.005, 0.0150], [0.0498, 0, 0.0030], 0
    yield mujoco.mjtGeom.mjGEOM_BOX, [0.0092, 0.005, 0.0035], [0.0388, 0, -0.0160], 0


def make_peer(mug):
    env = gymnasium.make("AdroitHandRelocate-v1")
    inner = env.unwrapped
    if not mug:
        return env
    spec = mujoco.MjSpec.from_file(inner.fullpath)
    body = spec.body("Object")
    for geom in list(body.geoms):
        spec.delete(geom)
    for kind, size, position, angle in mug_parts():
        body.add_geom(
            type=kind, size=size, pos=position, condim=4, friction=[1, 0.5, 0.01],
            quat=[math.cos(angle / 2), 0, 0, math.sin(angle / 2)], density=1000,
        )  # fmt: skip
    spec.nconmax = spec.njmax = -1
    inner.model = spec.compile()
    inner.data = mujoco.MjData(inner.model)
    return env


def peer_steps_per_second(env, policy, episodes, seed):
    """Steps a second of processor time and of elapsed time."""
    model = env.unwrapped.model
    ball = model.body("Object").id
    start, clock = time.process_time(), time.monotonic()
    for episode in range(episodes):
        observation, _ = env.reset(seed=seed + episode)
        model.body_pos[ball, :2] = (-0.0625, 0)
        for _ in range(STEPS):
            observation = env.step(policy(observation))[0]
    steps = episodes * STEPS
    return steps / (time.process_time() - start), steps / (time.monotonic() - clock)


def rollout(arguments, solver, threads, episodes, seed):
    """Processor time and elapsed steps a second of one rollout."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    command = [
        arguments.palpate, "rollout", arguments.policy, "--episodes", str(episodes), "--threads",
        str(threads), "--seed", str(seed), "--set", f"task.solver={solver}", "--json",
    ]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    spent = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    return spent, json.loads(done.stdout)["steps_per_second"]


def palpate_steps_per_second(arguments, solver, seed):
    # What starting costs is taken out by the difference of two runs.
    few, many = 2, arguments.episodes + 2
    return arguments.episodes * STEPS / (
        rollout(arguments, solver, 1, many, seed)[0] - rollout(arguments, solver, 1, few, seed)[0]
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("palpate")
    parser.add_argument("policy")
    parser.add_argument("--episodes", type=int, default=20)
    parser.add_argument("--rounds", type=int, default=3)
    arguments = parser.parse_args()
    gymnasium.register_envs(gymnasium_robotics)
    policy = Network(arguments.policy)
    peers = {"peer, its ball": make_peer(False), "peer, a mug": make_peer(True)}
    solvers = ("faithful", "newton", "fast")
    spent, elapsed, scaling = ({name: [] for name in (*peers, *solvers)} for _ in range(3))
    for round_ in range(arguments.rounds):
        seed = 9000 + 100 * round_
        for name, env in peers.items():
            processor, clock = peer_steps_per_second(env, policy, arguments.episodes, seed)
            spent[name].append(processor)
            elapsed[name].append(clock)
        for solver in solvers:
            spent[solver].append(palpate_steps_per_second(arguments, solver, seed))
            one = rollout(arguments, solver, 1, arguments.episodes, seed)[1]
            two = rollout(arguments, solver, 2, arguments.episodes, seed)[1]
            elapsed[solver].append(two)
            scaling[solver].append(two / one)
    print_table("steps/s of processor time, 1 thread", spent)
    print_table("steps/s elapsed, peer 1 thread, palpate 2", elapsed)
    for solver in solvers:
        print(f"two threads against one, elapsed, {solver}: {statistics.median(scaling[solver]):.2f}")


def print_table(title, rates):
    medians = {name: statistics.median(values) for name, values in rates.items()}
    print(f"{title:<44}{'ratio to the ball':>18}{'to the mug':>12}")
    for name, value in medians.items():
        ball, mug = (value / medians[f"peer, {what}"] for what in ("its ball", "a mug"))
        print(f"  {name:<16}{value:>10.0f}{ball:>34.2f}{mug:>12.2f}")


if __name__ == "__main__":
    main()
