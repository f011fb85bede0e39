# SPDX-License-Identifier: Apache-2.0
"""Learn the published relocate task from nothing: stable-baselines3's PPO on Palpate/Relocate-v2.

usage: learn_relocate.py [--steps N] [--object NAME] [--episodes N] [--seed S] [--out FOLDER]
       pip install 'palpate[gym]' palpate-sim stable-baselines3

The policy has the 39 observations of the published one, and no demonstrations. It learns on the
fast solver, on episodes of seeds below 2048; what is printed at the end is of the faithful solver
and fresh starts, those of `palpate rollout --seed 9770`.
"""

import argparse
import csv
import pathlib

import gymnasium
import numpy as np
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import DummyVecEnv, VecMonitor, VecNormalize

TASK = "palpate.envs:Palpate/Relocate-v2"
SEED = 9770 * 2**20  # of the first episode of that seed of `palpate rollout`
GAMMA = 0.99
ROUNDS_A_LINE = 10


def make(given, solver):
    return gymnasium.make(TASK, object=given.object, flat=True, solver=solver)


class Curve(BaseCallback):
    """Keeps the mean return of the last 100 episodes after each round of steps; prints some."""

    def __init__(self):
        super().__init__()
        self.rows = []

    def _on_step(self):
        return True

    def _on_rollout_end(self):
        returns = [episode["r"] for episode in self.model.ep_info_buffer]
        self.rows.append((self.num_timesteps, float(np.mean(returns))))
        if len(self.rows) % ROUNDS_A_LINE == 1:
            print(f"{self.rows[-1][0]} steps: return {self.rows[-1][1]:.0f}", flush=True)


def judge(given, policy, scaled):
    """Of fresh episodes: return and the object's last distance from its target, m."""
    env = make(given, "faithful")
    rows = []
    for episode in range(given.episodes):
        observation, info = env.reset(seed=SEED + episode)
        total, over = 0.0, False
        while not over:
            action = policy.predict(scaled.normalize_obs(observation), deterministic=True)[0]
            observation, reward, terminated, truncated, info = env.step(action)
            total, over = total + reward, terminated or truncated
        rows.append((total, info["distance"]))
    return np.array(rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--steps", type=int, default=3_000_000)
    parser.add_argument("--object", default="mug")
    parser.add_argument("--episodes", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=pathlib.Path, help="keep policy, scales and curve here")
    given = parser.parse_args()
    torch.set_num_threads(1)
    envs = DummyVecEnv([lambda: make(given, "fast")] * 8)
    envs = VecNormalize(VecMonitor(envs), gamma=GAMMA)
    policy = PPO("MlpPolicy", envs, n_steps=512, batch_size=512, n_epochs=5, gamma=GAMMA,
                 policy_kwargs={"log_std_init": -1.0, "net_arch": [128, 128]},
                 seed=given.seed, device="cpu")  # fmt: skip
    curve = Curve()
    policy.learn(given.steps, callback=curve)
    envs.training = False
    if given.out:
        given.out.mkdir(parents=True, exist_ok=True)
        policy.save(given.out / "policy")
        envs.save(given.out / "scales.pkl")
        with open(given.out / "curve.csv", "w", newline="") as file:
            csv.writer(file).writerows([("steps", "return"), *curve.rows])
    returns, distances = judge(given, policy, envs).T
    print(f"{given.episodes} fresh starts: return {returns.mean():.0f} +- {returns.std():.0f}, "
          f"within 10, 5, 2 cm: {(distances < 0.1).mean():.2f}, {(distances < 0.05).mean():.2f}, "
          f"{(distances < 0.02).mean():.2f}")  # fmt: skip


if __name__ == "__main__":
    main()
