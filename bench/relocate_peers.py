# SPDX-License-Identifier: Apache-2.0
"""Steps a second of palpate's relocate task and of gymnasium-robotics', in one run.

usage: relocate_peers.py PALPATE POLICY [--episodes N] [--rounds R]

POLICY is a network on the 39 observations (kind "mlp", as `palpate train relocate --method dagger`
makes it); it drives both, for 99 steps an episode. The peer relocates its own ball, which is put
where the mug starts. Rounds alternate between the two, and the medians are compared. Times are
processor time on one thread, so that other work on the machine counts against nobody, and elapsed
time on two threads against one.
"""

import argparse
import json
import resource
import statistics
import subprocess
import time

import gymnasium
import gymnasium_robotics
import numpy as np

STEPS = 99


class Network:
    def __init__(self, path):
        record = json.load(open(path))
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


def peer_steps_per_second(env, policy, episodes, seed):
    model = env.unwrapped.model
    ball = model.body("Object").id
    start = time.process_time()
    for episode in range(episodes):
        observation, _ = env.reset(seed=seed + episode)
        model.body_pos[ball, :2] = (-0.0625, 0)
        for _ in range(STEPS):
            observation = env.step(policy(observation))[0]
    return episodes * STEPS / (time.process_time() - start)


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
    env = gymnasium.make("AdroitHandRelocate-v1")
    policy = Network(arguments.policy)
    rates = {name: [] for name in ("gymnasium-robotics", "faithful", "newton", "fast")}
    scaling = []
    for round_ in range(arguments.rounds):
        seed = 9000 + 100 * round_
        rates["gymnasium-robotics"].append(
            peer_steps_per_second(env, policy, arguments.episodes, seed))
        for solver in ("faithful", "newton", "fast"):
            rates[solver].append(palpate_steps_per_second(arguments, solver, seed))
        one = rollout(arguments, "newton", 1, arguments.episodes, seed)[1]
        two = rollout(arguments, "newton", 2, arguments.episodes, seed)[1]
        scaling.append(two / one)
    peer = statistics.median(rates["gymnasium-robotics"])
    print(f"{'':<20}{'steps/s, 1 thread':>18}{'ratio':>8}")
    for name, values in rates.items():
        value = statistics.median(values)
        print(f"{name:<20}{value:>18.0f}{value / peer:>8.2f}")
    print(f"two threads against one (newton, elapsed): {statistics.median(scaling):.2f}")


if __name__ == "__main__":
    main()
