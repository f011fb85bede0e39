# SPDX-License-Identifier: Apache-2.0
"""The environments Palpate/Place-v0 and Palpate/Reorient-v0, which need palpate.sim."""

import numpy as np

from . import _core
from .envs import known_model
from .hand_env import HandEnv

_LEVER = 0.05  # m: a turn by an angle counts as a shift by so much times the angle
_REACHED = np.radians(5), 0.01  # rad, m
_STAYS = 10  # steps in which the object stays where it should be
_DROPPED = 0.05  # m


def _turned(axis, angle):
    """Rotation about a unit axis (Rodrigues)."""
    x, y, z = axis
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


class _GoalEnv(HandEnv):
    """Bring the object to a pose; a reward is by how much it came nearer, in m."""

    def __init__(self, object, hand, *, max_steps, render_mode):
        self.model = known_model(object)
        asked = {"target": ((4, 4), 2)}
        super().__init__(
            self.model, hand, max_steps=max_steps, render_mode=render_mode, asked=asked
        )

    def set_target(self, target):
        self.target, self.stayed, self.sensed = target, 0, None
        self.rotation, self.translation = self.error()

    def error(self):
        """Of the object from the target, modulo symmetry: rad, m."""
        return _core.pose_error(self.model, self.pose(), self.target)

    def pose(self):
        """The object's pose in the frame of the target."""
        return self.world.truth()

    def left(self):
        """By how much the object is not yet where it should be, m."""
        return self.translation + _LEVER * self.rotation

    def asked(self, sensed):
        return sensed | {"target": np.clip(self.target, -2, 2)}

    def step(self, action):
        sensed = self.move(action)
        before = self.left()
        self.rotation, self.translation = self.error()
        self.stayed = self.stayed + 1 if self.reached(sensed) else 0
        terminated = self.stayed >= _STAYS or self.lost()
        truncated = not terminated and self.steps >= self.max_steps
        return self.asked(sensed), before - self.left(), terminated, truncated, self.info(sensed)

    def lost(self):
        return False

    def info(self, sensed):
        return {
            "truth": self.world.truth(),
            "rotation_error_deg": float(np.degrees(self.rotation)),
            "translation_error_mm": 1e3 * self.translation,
            "reached": self.reached(sensed),
        }


class PlaceEnv(_GoalEnv):
    """Palpate/Place-v0: bring an object to another place and yaw on the table, and let go of it.

    Actions and observations are those of palpate.hand_env.HandEnv; `target` (4, 4), the pose to
    be reached, T_world_object, is observed too. It is 8 to 15 cm from where the object rests, on
    the same side of it.
    Reward: by how much the object came nearer, m, 5 cm a radian. An episode terminates once no
    fingertip has touched it for half a second within 5 deg and 10 mm, modulo symmetry, of the
    target, and is truncated after `max_steps`.
    Info: `truth` (4, 4), `rotation_error_deg`, `translation_error_mm`, `reached`.
    """

    def __init__(self, object="box", hand="shadow", *, max_steps=1000, render_mode=None):
        super().__init__(object, hand, max_steps=max_steps, render_mode=render_mode)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.world.reset(int(self.np_random.integers(2**31)))
        sensed = self.begin(self.start)
        target = self.world.truth()
        target[:3, :3] = _turned([0, 0, 1], self.np_random.uniform(-np.pi, np.pi)) @ target[:3, :3]
        way, bearing = self.np_random.uniform(0.08, 0.15), self.np_random.uniform(-np.pi, np.pi)
        target[:2, 3] += way * np.array([np.cos(bearing), np.sin(bearing)])
        self.set_target(target)
        return self.asked(sensed), self.info(sensed)

    def reached(self, sensed):
        near = self.rotation < _REACHED[0] and self.translation < _REACHED[1]
        return bool(near and not sensed["contacts"].any())


class ReorientEnv(_GoalEnv):
    """Palpate/Reorient-v0: turn an object that hangs in the fingers, without dropping it.

    An episode starts with the object grasped from above and lifted by 10 cm. Actions and
    observations are those of palpate.hand_env.HandEnv; `target` (4, 4), the pose to be reached in
    the frame of the hand's mount, T_mount_object, is observed too: 10 to 40 deg about any axis from
    where the object is.
    Reward: by how much the object came nearer, m, 5 cm a radian. An episode terminates once the
    object has been within 5 deg of the target, modulo symmetry, for half a second, or has fallen,
    and is truncated after `max_steps`.
    Info: `truth` (4, 4), `rotation_error_deg`, `translation_error_mm`, `reached`, `dropped`.
    """

    def __init__(self, object="box", hand="shadow", *, max_steps=400, render_mode=None):
        super().__init__(object, hand, max_steps=max_steps, render_mode=render_mode)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        command = self.world.grasp(int(self.np_random.integers(2**31)))
        sensed = self.begin(command)
        target = self.pose()
        axis = self.np_random.standard_normal(3)
        angle = np.radians(self.np_random.uniform(10, 40))
        target[:3, :3] = _turned(axis / np.linalg.norm(axis), angle) @ target[:3, :3]
        self.height = self.world.truth()[2, 3]
        self.set_target(target)
        return self.asked(sensed), self.info(sensed)

    def pose(self):
        return np.linalg.inv(self.world.T_world_mount) @ self.world.truth()

    def reached(self, sensed):
        return bool(self.rotation < _REACHED[0] and not self.lost())

    def lost(self):
        return bool(self.world.truth()[2, 3] < self.height - _DROPPED)

    def info(self, sensed):
        return super().info(sensed) | {"dropped": self.lost()}
