# SPDX-License-Identifier: Apache-2.0
"""The environment Palpate/Relocate-v2, one of it or many at once, which needs palpate.sim."""

import os

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from . import sim
from .envs import known_mode, require_reset

_ACTIONS, _OBSERVATIONS = 30, 39
_PARTS = {  # of the published observation
    "joints": slice(0, 30),
    "palm_from_object": slice(30, 33),
    "palm_from_target": slice(33, 36),
    "object_from_target": slice(36, 39),
}
_LIMIT, _SPEED_LIMIT = 10.0, 100.0
_SEEDS = 2**64  # that there are; gymnasium knows more


def _observation_space(flat):
    if flat:
        return spaces.Box(-_LIMIT, _LIMIT, (_OBSERVATIONS,), np.float64)
    parts = {
        name: spaces.Box(-_LIMIT, _LIMIT, (part.stop - part.start,), np.float64)
        for name, part in _PARTS.items()
    }
    return spaces.Dict(parts | {"velocities": spaces.Box(-_SPEED_LIMIT, _SPEED_LIMIT, (_ACTIONS,), np.float64)})  # fmt: skip  # noqa: E501


def _observe(tasks, flat):
    """What all tasks observe, a row each."""
    rows = np.clip(tasks.observations, -_LIMIT, _LIMIT)
    if flat:
        return rows
    speeds = np.clip(tasks.velocities, -_SPEED_LIMIT, _SPEED_LIMIT)
    return {name: rows[:, part] for name, part in _PARTS.items()} | {"velocities": speeds}


def _infos(tasks):
    """The truth of all tasks, a row each."""
    return {
        "truth": tasks.positions,
        "target": tasks.targets,
        "distance": tasks.distances,
        "contact": tasks.contacts,
    }


def _row(values, index):
    """Of one task; numbers and truths as Python's own, of which gymnasium makes arrays."""
    return {
        name: rows[index] if rows.ndim > 1 else rows[index].item() for name, rows in values.items()
    }


def _place(tasks, index, options):
    """Starts a task where the options of a reset say."""
    if set(options) != {"object", "target"}:
        raise ValueError(f"options of a reset are object and target, not {', '.join(options)}")
    tasks.place(index, object=options["object"], target=options["target"])


class RelocateEnv(gymnasium.Env):
    """Palpate/Relocate-v2: the Adroit hand brings an object from a table to a target in the air.

    The task of `palpate rollout`, with its observation, action and reward (docs/manipulation.md).
    Action, (30,), -1..1 over the ranges of the actuators, for 10 ms.
    Observation: `joints` (30,), m and rad; `palm_from_object`, `palm_from_target`,
    `object_from_target` (3,), m, world axes, the object's place with the error that `object_bias`
    makes; `velocities` of the joints (30,). With `flat` the first four as one array (39,), as
    published.
    An episode is truncated after the option `horizon` (99 steps), and terminates where the physics
    fails. `reset(seed=s)` starts episode s % 2^20 of the seed s / 2^20 of `palpate rollout`
    (s % 2^64);
    `reset(options={"object": (2,), "target": (3,)})` starts with the object and its target there, m.
    Info: `truth` (37,): joints, place (m) and quaternion (w, x, y, z) of the object; `target` (3,),
    m; `distance` of the object from it, m; `contact` of hand and object.
    `render_mode="rgb_array"` draws it (height, width, 3) where OpenGL works, the object see-through
    at its target, too.

    Raises ValueError for an object or an option that there is not: `solver`, `mass_scale`,
    `friction_scale`, `size`, `mass`, `horizon`, `scale_low`, `scale_high`, `at_ends`,
    `object_bias`, `observation_period`, `encoder_noise`.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 100}

    def __init__(self, object="mug", *, flat=False, render_mode=None, **task):
        self.tasks = sim.RelocateTasks(1, options={"object": object, **task})
        self.flat, self.render_mode = flat, known_mode(self, render_mode)
        self.steps = None  # until the first reset
        self.action_space = spaces.Box(-1, 1, (_ACTIONS,), np.float64)
        self.observation_space = _observation_space(flat)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        drawn = int(self.np_random.integers(2**31))
        self.tasks.reset(0, drawn if seed is None else seed % _SEEDS)
        if options:
            _place(self.tasks, 0, options)
        self.steps = 0
        return self._observation(), _row(_infos(self.tasks), 0)

    def step(self, action):
        require_reset(self.steps, "step")
        self.tasks.step(np.asarray(action, np.float64)[None])
        self.steps += 1
        terminated = bool(self.tasks.diverged[0])
        truncated = not terminated and self.steps >= self.tasks.horizon
        reward = float(self.tasks.rewards[0])
        return self._observation(), reward, terminated, truncated, _row(_infos(self.tasks), 0)

    def render(self):
        """The scene as it is now, (360, 480, 3), uint8; None without a render mode."""
        if self.render_mode != "rgb_array":
            return None
        require_reset(self.steps, "render")
        return self.tasks.render(0)

    def _observation(self):
        seen = _observe(self.tasks, self.flat)
        return seen[0] if self.flat else _row(seen, 0)


class RelocateVectorEnv(VectorEnv):
    """Many of Palpate/Relocate-v2, stepped by the C++ library on `threads` threads (all cores).

    `gymnasium.make_vec("palpate.envs:Palpate/Relocate-v2", 8, vectorization_mode="vector_entry_point")`.
    The same as gymnasium's SyncVectorEnv of as many, bit for bit: an episode that has ended starts
    again in the next step, which ignores its action.
    """

    metadata = RelocateEnv.metadata | {"autoreset_mode": AutoresetMode.NEXT_STEP}

    def __init__(
        self, num_envs=1, object="mug", *, threads=None, flat=False, render_mode=None, **task
    ):
        threads = min(num_envs, threads or os.cpu_count() or 1)
        self.tasks = sim.RelocateTasks(
            num_envs, threads=threads, options={"object": object, **task}
        )
        self.num_envs, self.flat = num_envs, flat
        self.render_mode = known_mode(self, render_mode)
        self.single_action_space = spaces.Box(-1, 1, (_ACTIONS,), np.float64)
        self.single_observation_space = _observation_space(flat)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.randoms = [seeding.np_random()[0] for _ in range(num_envs)]
        self.over = None  # before the first reset

    def reset(self, *, seed=None, options=None):
        if not isinstance(seed, (list, tuple)):
            seed = [None if seed is None else seed + i for i in range(self.num_envs)]
        if len(seed) != self.num_envs:
            raise ValueError(f"{len(seed)} seeds of {self.num_envs} environments")
        for index, one in enumerate(seed):
            if one is not None:
                self.randoms[index] = seeding.np_random(one)[0]
            self._begin(index, one)
            if options:
                _place(self.tasks, index, options)
        self.steps = np.zeros(self.num_envs, int)
        self.over = np.zeros(self.num_envs, bool)
        return _observe(self.tasks, self.flat), self._infos()

    def step(self, actions):
        require_reset(self.over, "step")
        for index in np.flatnonzero(self.over):
            self._begin(index, None)
        self.tasks.step(actions, self.over)
        self.steps = np.where(self.over, 0, self.steps + 1)
        terminated = self.tasks.diverged
        truncated = ~terminated & (self.steps >= self.tasks.horizon)
        self.over = terminated | truncated
        observations = _observe(self.tasks, self.flat)
        return observations, self.tasks.rewards, terminated, truncated, self._infos()

    def render(self):
        """A picture of each, as gymnasium's vectors give them; None without a render mode."""
        if self.render_mode != "rgb_array":
            return None
        require_reset(self.over, "render")
        return tuple(self.tasks.render(index) for index in range(self.num_envs))

    def _begin(self, index, seed):
        drawn = int(self.randoms[index].integers(2**31))
        self.tasks.reset(int(index), drawn if seed is None else seed % _SEEDS)

    def _infos(self):
        """As gymnasium's vectors have them: which environments have a value, too."""
        values, there = _infos(self.tasks), np.ones(self.num_envs, bool)
        return values | {f"_{name}": there for name in values}
