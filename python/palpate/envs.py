# SPDX-License-Identifier: Apache-2.0
"""Gymnasium environments (`pip install palpate[gym]`): `gymnasium.make("palpate.envs:Palpate/Touch-v0")`.

Observations hold only what is sensed or estimated from it; the truth is in `info`.
"""

import gymnasium
import numpy as np
from gymnasium import spaces

from . import _core

_TOLERANCE_DEG, _TOLERANCE_MM = 5.0, 10.0  # of a pose that is correct
_CERTAIN = 0.95  # probability that ends an episode
_HALF_WIDTH = 0.02  # m, by which the object's place is known beforehand
_CLEARANCE = 0.05  # m, from which a touch starts, beyond the object's reach
_MOST_NOISE, _MOST_NOISE_DEG = 0.1, 90.0  # m, deg: that Contacts can state
_PICTURE = 240  # pixels, of each of the two views
_GREY, _BLUE, _RED = (190, 190, 190), (40, 90, 220), (220, 40, 40)
_DRAWN = 4000  # points of the object's surface


def known_mode(environment, render_mode):
    """The mode. Raises ValueError for one that the environment does not draw in."""
    modes = environment.metadata["render_modes"]
    if render_mode is not None and render_mode not in modes:
        raise ValueError(f"render_mode {render_mode!r}: it is None or one of {modes}")
    return render_mode


def require_reset(state, call):
    """Raises gymnasium.error.ResetNeeded where an environment has no state yet."""
    if state is None:
        raise gymnasium.error.ResetNeeded(f"{call}() before the first reset()")


def known_model(object):
    """The palpate.ObjectModel of a name, a mesh file in metres, or a model."""
    if isinstance(object, _core.ObjectModel):
        return object
    return _core.ObjectModel(_core.load_known_object(object))


def whole_count(name, value):
    """The integer. Raises ValueError for one that is not positive, and for other numbers."""
    if not 0 < value < np.inf:
        raise ValueError(f"{name} is {value}, not positive")
    if value != int(value):
        raise ValueError(f"{name} is {value}, not an integer")
    return int(value)


def _yaw(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


class TouchEnv(gymnasium.Env):
    """Palpate/Touch-v0: choose touches that determine the pose of an object at rest on a table.

    A ball comes horizontally towards the object. The frame is that of the table, z up, its origin
    at the rough place of the object, which is known to 20 mm.

    Action, (3,), -1..1: azimuth of the approach over pi; height of the line over the object's
    largest; its offset to the side over the object's radius.
    Observation: `contacts` (max_touches, 6): point (m) and normal sensed by each touch, zeros for
    misses and touches not made; `touches`: how many were made; `probability` of the best pose;
    `T_table_object` (4, 4): the best pose, the identity while there is none.
    Reward: the gain in probability, less `cost` a touch. An episode terminates when the
    probability exceeds 0.95 and is truncated after `max_touches`.
    Info: `truth` (4, 4), `hit`, and with a pose `correct`, `rotation_error_deg`,
    `translation_error_mm`.
    object: a name, a mesh file in metres, or a palpate.ObjectModel.
    `render_mode="rgb_array"`: from above and from the side (240, 480, 3): the object grey, at the
    best pose blue, contacts red.

    Raises ValueError for an object that there is not, for sizes that are not positive, and for
    noise above 0.1 m or 90 deg; gymnasium.error.ResetNeeded for a step after `max_touches`.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 2}

    def __init__(
        self, object="mug", *, max_touches=12, cost=0.01, tip_radius=0.0075, point_noise=0.001,
        normal_noise_deg=10.0, proposals=6000, particles=200, render_mode=None,
    ):  # fmt: skip
        max_touches = whole_count("max_touches", max_touches)
        for name, value, most in (
            ("tip_radius", tip_radius, np.inf),
            ("point_noise", point_noise, _MOST_NOISE),
            ("normal_noise_deg", normal_noise_deg, _MOST_NOISE_DEG),
        ):
            if not 0 < value < np.inf:
                raise ValueError(f"{name} is {value}, not positive")
            if value > most:
                raise ValueError(f"{name} is {value}, more than {most}")
        if not np.isfinite(cost):
            raise ValueError(f"cost is {cost}, not finite")
        self.model = known_model(object)
        self.max_touches, self.cost, self.tip_radius = max_touches, cost, tip_radius
        self.point_noise, self.normal_noise = point_noise, np.radians(normal_noise_deg)
        self.search = {"proposals": proposals, "particles": particles}
        self.render_mode, self.truth = known_mode(self, render_mode), None  # until the first reset
        self.mesh = self.model.object.mesh
        vertices = self.mesh.vertices
        self.radius = float(np.linalg.norm(vertices, axis=1).max())
        self.action_space = spaces.Box(-1, 1, (3,), np.float64)
        self.observation_space = spaces.Dict(
            {
                "contacts": spaces.Box(-2, 2, (max_touches, 6), np.float64),
                "touches": spaces.Discrete(max_touches + 1),
                "probability": spaces.Box(0, 1, (1,), np.float64),
                "T_table_object": spaces.Box(-2, 2, (4, 4), np.float64),
            }
        )

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.truth = self._random_rest()
        self.sensed = np.zeros((self.max_touches, 6))
        self.touches, self.free, self.posterior = 0, [], None
        return self._observation(), self._info(hit=False)

    def step(self, action):
        require_reset(self.truth, "step")
        if self.touches == self.max_touches:
            raise gymnasium.error.ResetNeeded(f"step() after the last of {self.touches} touches")
        before = self._probability()
        touch = self.touch(action)
        result = _core.predict_touch(self.model, self.truth, touch, tip_radius=self.tip_radius)
        self._sense(touch, result)
        self.posterior = self._localize()
        gain = self._probability() - before
        terminated = self._probability() > _CERTAIN
        truncated = not terminated and self.touches >= self.max_touches
        info = self._info(result.hit)
        return self._observation(), gain - self.cost, terminated, truncated, info

    def render(self):
        """A picture of what is there and what is believed, uint8; None without a render mode."""
        if self.render_mode != "rgb_array":
            return None
        require_reset(self.truth, "render")
        picture = np.full((_PICTURE, 2 * _PICTURE, 3), 255, np.uint8)
        self._draw(picture, self._surface(), self.truth, _GREY)
        if self._best():
            self._draw(picture, self._surface()[::3], self._best().T_frame_object, _BLUE)
        points = self.sensed[np.any(self.sensed[:, 3:], axis=1), :3]
        around = np.array([[x, y, z] for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1)])
        self._draw(picture, (points[:, None] + 0.001 * around).reshape(-1, 3), np.eye(4), _RED)
        return picture

    def _surface(self):
        """Points of the object's surface, (N, 3), m, in its frame."""
        near = np.random.default_rng(0).uniform(-self.radius, self.radius, (_DRAWN, 3))
        return self.mesh.closest_points(near).points

    def _draw(self, picture, points, T, colour):
        """Points as pixels, from above in the left half, from the side in the right."""
        x, y, z = T[:3, :3] @ points.T + T[:3, 3:]
        half = self.radius + 2 * _HALF_WIDTH
        scale, middle = (_PICTURE / 2 - 1) / half, _PICTURE / 2
        for across, up, left in ((x, y, 0), (x, z - half + _HALF_WIDTH, _PICTURE)):
            columns = np.round(middle + scale * across).astype(int)
            rows = np.round(middle - scale * up).astype(int)
            inside = (rows >= 0) & (rows < _PICTURE) & (columns >= 0) & (columns < _PICTURE)
            picture[rows[inside], left + columns[inside]] = colour

    def touch(self, action):
        """The palpate.TouchAction that an action stands for."""
        action = np.asarray(action, np.float64)
        if action.shape != (3,) or not np.isfinite(action).all():
            raise ValueError(f"action {action.tolist()} is not three finite numbers")
        azimuth, height, offset = np.clip(action, -1, 1)
        R = _yaw(np.pi * azimuth)
        reach = self.radius + _HALF_WIDTH + _CLEARANCE
        z = self.tip_radius + (height + 1) * self.radius
        start = R @ [reach, offset * (self.radius + _HALF_WIDTH), 0] + [0, 0, z]
        return _core.TouchAction(start, R @ [-1, 0, 0], reach=2 * reach)

    def _random_rest(self):
        poses = self.model.object.stable_poses
        shares = np.array([pose.probability for pose in poses])
        rest = poses[self.np_random.choice(len(poses), p=shares / shares.sum())]
        T = np.eye(4)
        T[:3, :3] = _yaw(self.np_random.uniform(-np.pi, np.pi)) @ rest.R_table_object
        T[:3, 3] = [*self.np_random.uniform(-_HALF_WIDTH, _HALF_WIDTH, 2), rest.height]
        return T

    def _sense(self, touch, result):
        """Notes where the ball was stopped, with noise, and where it passed through air."""
        end = touch.start + result.distance * touch.direction
        if result.hit:
            n = result.normal + self.normal_noise * self._across(result.normal)
            point = end - self.tip_radius * result.normal
            noisy = point + self.point_noise * self.np_random.standard_normal(3)
            self.sensed[self.touches] = [*noisy, *n / np.linalg.norm(n)]
        steps = np.arange(0, result.distance - 3 * self.point_noise, self.tip_radius)
        for p in touch.start + steps[:, None] * touch.direction:
            if np.hypot(p[0], p[1]) < self.radius + _HALF_WIDTH:
                self.free.append([*p, self.tip_radius])
        self.touches += 1

    def _across(self, n):
        """Standard normal in the two directions across n."""
        v = self.np_random.standard_normal(3)
        return v - n * (n @ v)

    def _localize(self):
        made = self.sensed[np.any(self.sensed[:, 3:], axis=1)]
        if not len(made):
            return None
        contacts = _core.Contacts(
            made[:, :3], made[:, 3:], point_sigma=self.point_noise, normal_sigma=self.normal_noise
        )
        return _core.localize(
            self.model, contacts, table=_core.TableSupport(np.eye(4), half_width=_HALF_WIDTH),
            free_space=self.free or None, seed=int(self.np_random.integers(2**31)), **self.search,
        )  # fmt: skip

    def _best(self):
        return self.posterior.best if self.posterior else None

    def _probability(self):
        return self.posterior.probability if self.posterior else 0.0

    def _observation(self):
        best = self._best()
        return {
            "contacts": np.clip(self.sensed, -2, 2),
            "touches": self.touches,
            "probability": np.clip([self._probability()], 0, 1),
            "T_table_object": np.clip(best.T_frame_object, -2, 2) if best else np.eye(4),
        }

    def _info(self, hit):
        info = {"truth": self.truth.copy(), "hit": bool(hit)}
        if self._best():
            rotation, translation = self.posterior.error(self.truth)
            info["rotation_error_deg"] = float(np.degrees(rotation))
            info["translation_error_mm"] = 1e3 * translation
            info["correct"] = bool(
                info["rotation_error_deg"] < _TOLERANCE_DEG
                and info["translation_error_mm"] < _TOLERANCE_MM
            )
        return info


_ENTRIES = {
    "Touch-v0": "palpate.envs:TouchEnv",
    "Pick-v0": "palpate.pick_env:PickEnv",
    "Place-v0": "palpate.place_env:PlaceEnv",
    "Reorient-v0": "palpate.place_env:ReorientEnv",
    "Relocate-v2": "palpate.relocate_env:RelocateEnv",
}
_VECTORS = {"Relocate-v2": "palpate.relocate_env:RelocateVectorEnv"}


def register_envs():
    """Makes the environments known to gymnasium; importing palpate after gymnasium does so."""
    for name, entry in _ENTRIES.items():
        if f"Palpate/{name}" not in gymnasium.registry:
            gymnasium.register(
                id=f"Palpate/{name}", entry_point=entry, vector_entry_point=_VECTORS.get(name)
            )


register_envs()
