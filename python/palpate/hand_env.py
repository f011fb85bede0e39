# SPDX-License-Identifier: Apache-2.0
"""What the environments of a simulated hand share; they need palpate.sim.

Observations hold only what the hand senses and what it is asked for; the truth is in `info`.
"""

import gymnasium
import numpy as np
from gymnasium import spaces

from . import _core, sim
from .envs import known_mode, require_reset, whole_count

_TICKS = 5  # of 10 ms, a step
_RATES = np.array([0.015] * 3 + [0.075] * 3)  # m, rad: largest change of the mount's command a step
_FINGER_RATE = 0.1  # rad a step
_REACH = 0.5  # m of the mount from the origin, to either side and upwards


class HandEnv(gymnasium.Env):
    """A simulated hand and an object on a table; environments derive from it.

    Action, (6 + A,), -1..1: change of the commanded mount (x, y, z, yaw, pitch, roll) over 15 mm or
    0.075 rad, and of each actuator's command over 0.1 rad, in 50 ms.
    Observation, of the last tick: `joints` (J,), rad; `torques` (A,), N m; `mount` (6,), m and rad;
    `mount_force` (3,), N; `contacts` (F, 9): point (m), normal and force (N) of each fingertip's
    strongest contact in its link's frame, zeros for none; `command` (6 + A,), m and rad.
    object: a name, a mesh file in metres, or a palpate.ObjectModel.
    `render_mode="rgb_array"` draws it (height, width, 3) where OpenGL works.

    Raises ValueError for what there is not, and for `max_steps` that are no positive integer.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 20}

    def __init__(self, object, hand, *, max_steps, render_mode, asked=None):
        self.max_steps = whole_count("max_steps", max_steps)
        self.render_mode = known_mode(self, render_mode)
        self.world = sim.World(object, hand=hand, options=sim.IDEAL)
        self.command = None  # until the first reset
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
            "joints": (len(description.joints), 10), "torques": (len(ranges), 50), "mount": (6, 10),
            "mount_force": (3, 500), "contacts": ((len(description.fingers), 9), 500),
            "command": (len(self.low), 10),
        } | (asked or {})  # fmt: skip
        self.observation_space = spaces.Dict(
            {
                name: spaces.Box(-limit, limit, np.atleast_1d(shape).tolist(), np.float64)
                for name, (shape, limit) in limits.items()
            }
        )

    def begin(self, command):
        """Starts an episode at a command; returns what the hand senses there."""
        self.command = np.concatenate([command.mount_xyz, command.mount_ypr, command.positions])
        self.steps = 0
        return self._tick(self.command)

    def move(self, action):
        """Moves the command by an action in 50 ms; returns what the hand senses then."""
        require_reset(self.command, "step")
        action = np.asarray(action, np.float64)
        if action.shape != self.rates.shape or not np.isfinite(action).all():
            raise ValueError(f"action of shape {action.shape}, not {self.rates.shape}, or not finite")
        change = self.rates * np.clip(action, -1, 1)
        first = self.command
        self.command = np.clip(first + change, self.low, self.high)
        for share in np.arange(1, _TICKS + 1) / _TICKS:
            sensed = self._tick(first + share * (self.command - first))
        self.steps += 1
        return sensed

    def render(self):
        """The scene as it is now, (360, 480, 3), uint8; None without a render mode."""
        if self.render_mode != "rgb_array":
            return None
        require_reset(self.command, "render")
        return self.world.render()

    def _tick(self, command):
        reading = self.world.hand.step(_core.HandCommand(command[6:], command[:3], command[3:6]))
        seen = {
            "joints": reading.joints, "torques": reading.torques,
            "mount": np.concatenate([reading.mount_xyz, reading.mount_ypr]),
            "mount_force": reading.mount_force, "contacts": self._strongest(reading.contacts),
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
