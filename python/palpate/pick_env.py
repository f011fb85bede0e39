# SPDX-License-Identifier: Apache-2.0
"""The environment Palpate/Pick-v0, which needs palpate.sim.

Observations hold only what the hand senses; the truth is in `info`.
"""

import gymnasium
import numpy as np
from gymnasium import spaces

from . import _core, sim

_TICKS = 5  # of 10 ms, a step
_RATES = np.array([0.015] * 3 + [0.075] * 3)  # m, rad: largest change of the base's command a step
_FINGER_RATE = 0.1  # rad a step
_REACH = 0.5  # m of the base from the origin, to either side and upwards
_LIFTED = 0.05  # m
_HELD_STEPS = 10  # in which it stays lifted


class PickEnv(gymnasium.Env):
    """Palpate/Pick-v0: lift an object that rests within 2 cm of the origin, by touch.

    Action, (6 + A,), -1..1: change of the commanded base (x, y, z, yaw, pitch, roll) over 15 mm or
    0.075 rad, and of each actuator's command over 0.1 rad, in 50 ms.
    Observation, of the last tick: `joints` (J,), rad; `torques` (A,), N m; `base` (6,), m and rad;
    `base_force` (3,), N; `contacts` (F, 9): point (m), normal and force (N) of each fingertip's
    strongest contact, zeros for none; `command` (6 + A,), m and rad.
    Reward: by how much the object's centroid rose, m. An episode terminates once it has been 5 cm
    above its rest for half a second, and is truncated after `max_steps`.
    Info: `truth` (4, 4), `rise` (m), `lifted`.
    """

    metadata = {"render_modes": []}

    def __init__(self, object="box", hand="shadow", *, max_steps=600, render_mode=None):
        self.world = sim.World(object, hand=hand)
        self.max_steps, self.render_mode = max_steps, render_mode
        description = self.world.hand.description
        self.start = sim.waiting_command(description)
        ranges = [actuator.command for actuator in description.actuators]
        self.low, self.high = np.array(
            [[-_REACH, -_REACH, 0] + [-np.pi] * 3 + [low for low, _ in ranges],
             [_REACH] * 3 + [np.pi] * 3 + [high for _, high in ranges]]
        )  # fmt: skip
        self.rates = np.concatenate([_RATES, np.full(len(ranges), _FINGER_RATE)])
        self.action_space = spaces.Box(-1, 1, (len(self.low),), np.float64)
        limits = {
            "joints": (len(description.joints), 10), "torques": (len(ranges), 50), "base": (6, 10),
            "base_force": (3, 500), "contacts": ((len(description.fingers), 9), 500),
            "command": (len(self.low), 10),
        }  # fmt: skip
        self.observation_space = spaces.Dict(
            {
                name: spaces.Box(-limit, limit, np.atleast_1d(shape).tolist(), np.float64)
                for name, (shape, limit) in limits.items()
            }
        )

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.world.reset(int(self.np_random.integers(2**31)))
        self.command = np.concatenate(
            [self.start.base_xyz, self.start.base_ypr, self.start.positions]
        )
        self.steps, self.held = 0, 0
        self.rest = self.height = self.world.truth()[2, 3]
        return self._tick(), self._info()

    def step(self, action):
        change = self.rates * np.clip(np.asarray(action, np.float64), -1, 1)
        first = self.command
        self.command = np.clip(first + change, self.low, self.high)
        for share in np.arange(1, _TICKS + 1) / _TICKS:
            observation = self._tick(first + share * (self.command - first))
        before, self.height = self.height, self.world.truth()[2, 3]
        self.steps += 1
        self.held = self.held + 1 if self.height - self.rest > _LIFTED else 0
        terminated = self.held >= _HELD_STEPS
        truncated = not terminated and self.steps >= self.max_steps
        return observation, float(self.height - before), terminated, truncated, self._info()

    def _tick(self, command=None):
        command = self.command if command is None else command
        reading = self.world.hand.step(
            _core.HandCommand(command[6:], command[:3], command[3:6])
        )
        seen = {
            "joints": reading.joints, "torques": reading.torques,
            "base": np.concatenate([reading.base_xyz, reading.base_ypr]),
            "base_force": reading.base_force, "contacts": self._strongest(reading.contacts),
            "command": command,
        }  # fmt: skip
        bounds = self.observation_space
        return {name: np.clip(v, bounds[name].low, bounds[name].high) for name, v in seen.items()}

    def _strongest(self, contacts):
        rows = np.zeros((len(contacts), 9))
        for row, tip in zip(rows, contacts):
            if tip:
                contact = max(tip, key=lambda c: c.force @ c.force)
                row[:] = [*contact.point, *contact.normal, *contact.force]
        return rows

    def _info(self):
        rise = float(self.height - self.rest)
        return {"truth": self.world.truth(), "rise": rise, "lifted": rise > _LIFTED}
