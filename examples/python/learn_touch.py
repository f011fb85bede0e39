# SPDX-License-Identifier: Apache-2.0
"""Learn where to touch an object: stable-baselines3's PPO on Palpate/Touch-v0, beside chance.

usage: learn_touch.py [--minutes M] [--object NAME] [--episodes N] [--out FILE]
       pip install 'palpate[gym]' stable-baselines3

The policy sees what was sensed and estimated so far and chooses the next touch. It learns on
episodes of seeds below 1000; what is printed at the end is of the seeds from 9000 on, the same for
both.
"""

import argparse
import time

import gymnasium
import numpy as np
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import SubprocVecEnv

FIRST_SEED = 9000
SEARCH = {"proposals": 1000, "particles": 60}  # a quick localization, for learning and judging


def in_decimetres(observation):
    """Networks learn from numbers around 1; contacts are some centimetres from the origin."""
    scale = np.array([10, 10, 10, 1, 1, 1])
    return {**observation, "contacts": np.clip(scale * observation["contacts"], -2, 2)}


def make(given):
    env = gymnasium.make(
        "palpate.envs:Palpate/Touch-v0", object=given.object, max_touches=given.touches, **SEARCH
    )
    space = env.observation_space
    return gymnasium.wrappers.TransformObservation(env, in_decimetres, space)


class Clock(BaseCallback):
    """Ends learning when the time is up."""

    def __init__(self, seconds):
        super().__init__()
        self.end = time.monotonic() + seconds

    def _on_step(self):
        return time.monotonic() < self.end


def judge(given, choose):
    """Of fresh episodes: return, touches made, and whether the pose was right at the end."""
    env = make(given)
    rows = []
    for episode in range(given.episodes):
        observation, info = env.reset(seed=FIRST_SEED + episode)
        env.action_space.seed(FIRST_SEED + episode)
        total, over = 0.0, False
        while not over:
            observation, reward, terminated, truncated, info = env.step(choose(env, observation))
            total, over = total + reward, terminated or truncated
        rows.append((total, observation["touches"], info.get("correct", False)))
    return np.array(rows, float)


def report(name, rows):
    mean, error = rows.mean(axis=0), rows.std(axis=0) / np.sqrt(len(rows))
    print(f"{name}: return {mean[0]:.3f} +- {error[0]:.3f}, {mean[1]:.1f} touches, "
          f"{int(rows[:, 2].sum())} of {len(rows)} poses right", flush=True)  # fmt: skip


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--minutes", type=float, default=10)
    parser.add_argument("--object", default="box")
    parser.add_argument("--touches", type=int, default=8)
    parser.add_argument("--episodes", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", help="keep the policy in this file")
    given = parser.parse_args()
    torch.set_num_threads(1)  # the environments need the other cores
    envs = SubprocVecEnv([lambda: make(given)] * 2)
    policy = PPO("MultiInputPolicy", envs, n_steps=256, batch_size=128, learning_rate=1e-3,
                 gamma=0.95, ent_coef=0.003, seed=given.seed, device="cpu")  # fmt: skip
    policy.learn(10**9, callback=Clock(60 * given.minutes))
    envs.close()
    print(f"learnt for {given.minutes:g} minutes: {policy.num_timesteps} touches")
    if given.out:
        policy.save(given.out)
    report("chance", judge(given, lambda env, _: env.action_space.sample()))
    report("learnt", judge(given, lambda _, seen: policy.predict(seen, deterministic=True)[0]))


if __name__ == "__main__":
    main()
