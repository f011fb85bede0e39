# SPDX-License-Identifier: Apache-2.0
"""The environment Palpate/Pick-v0, which needs palpate.sim."""

from .hand_env import HandEnv

_LIFTED = 0.05  # m
_HELD_STEPS = 10  # in which it stays lifted


class PickEnv(HandEnv):
    """Palpate/Pick-v0: lift an object that rests within 2 cm of the origin, by touch.

    Actions and observations are those of palpate.hand_env.HandEnv.
    Reward: by how much the object's centroid rose, m. An episode terminates once it has been 5 cm
    above its rest for half a second, and is truncated after `max_steps`.
    Info: `truth` (4, 4), `rise` (m), `lifted`.
    """

    def __init__(self, object="box", hand="shadow", *, max_steps=600, render_mode=None):
        super().__init__(object, hand, max_steps=max_steps, render_mode=render_mode)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.world.reset(int(self.np_random.integers(2**31)))
        self.held = 0
        self.rest = self.height = self.world.truth()[2, 3]
        return self.begin(self.start), self._info()

    def step(self, action):
        observation = self.move(action)
        before, self.height = self.height, self.world.truth()[2, 3]
        self.held = self.held + 1 if self.height - self.rest > _LIFTED else 0
        terminated = self.held >= _HELD_STEPS
        truncated = not terminated and self.steps >= self.max_steps
        return observation, float(self.height - before), terminated, truncated, self._info()

    def _info(self):
        rise = float(self.height - self.rest)
        return {"truth": self.world.truth(), "rise": rise, "lifted": rise > _LIFTED}
