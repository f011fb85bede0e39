# SPDX-License-Identifier: Apache-2.0
"""The environments, where gymnasium is installed."""

import subprocess
import sys
import unittest
import warnings

import numpy as np

try:
    import gymnasium
    from gymnasium.utils.env_checker import check_env
    from palpate import _core as core
    from palpate import envs
except ImportError:
    gymnasium = None

try:
    import palpate.sim
    from palpate.pick_env import PickEnv
    from palpate.place_env import PlaceEnv
except ImportError:
    palpate = None

QUICK = {"object": "box", "max_touches": 6, "proposals": 2000, "particles": 60}


@unittest.skipUnless(gymnasium, "gymnasium is not installed")
class Names(unittest.TestCase):
    def test_environments_are_found_in_whatever_order_is_imported(self):
        for imports, prefix in [
            ("import palpate, gymnasium", "palpate.envs:"),
            ("import gymnasium", "palpate.envs:"),
            ("import gymnasium", "palpate:"),
            ("import palpate.envs, gymnasium", ""),
        ]:
            make = f"{imports}; gymnasium.make('{prefix}Palpate/Touch-v0', object='box')"
            subprocess.run([sys.executable, "-c", make], check=True, timeout=300)


@unittest.skipUnless(gymnasium, "gymnasium is not installed")
class Touch(unittest.TestCase):
    def test_check_env_is_clean(self):
        for mode in (None, "rgb_array"):
            env = gymnasium.make("palpate.envs:Palpate/Touch-v0", render_mode=mode, **QUICK)
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                check_env(env.unwrapped)

    def test_what_cannot_be_done_is_refused(self):
        for name, value in {"tip_radius": -1, "point_noise": 0, "max_touches": 0}.items():
            with self.assertRaisesRegex(ValueError, f"{name} is {value}, not positive"):
                gymnasium.make("palpate.envs:Palpate/Touch-v0", object="box", **{name: value})
        for name, value in {"max_touches": 2.5, "cost": np.nan, "render_mode": "human"}.items():
            with self.assertRaisesRegex(ValueError, f"{name} .*{value}"):
                envs.TouchEnv("box", **{name: value})
        for name, value in {"point_noise": 0.2, "normal_noise_deg": 91}.items():
            with self.assertRaisesRegex(ValueError, f"{name} is {value}, more than"):
                envs.TouchEnv("box", **{name: value})
        env = envs.TouchEnv(**QUICK, render_mode="rgb_array")
        for call in (lambda: env.step(np.zeros(3)), env.render):
            with self.assertRaisesRegex(gymnasium.error.ResetNeeded, "before the first reset"):
                call()
        env.reset(seed=1)
        for action in (np.full(3, np.nan), np.zeros(2), np.zeros((1, 3))):
            with self.assertRaisesRegex(ValueError, "is not three finite numbers"):
                env.step(action)

    def test_no_step_after_the_last_touch(self):
        env = envs.TouchEnv(**QUICK | {"max_touches": 2.0})
        observation, _ = env.reset(seed=1)
        self.assertEqual(observation["contacts"].shape, (2, 6))
        up = np.array([0.0, 1.0, 1.0])
        self.assertEqual([env.step(up)[3] for _ in range(2)], [False, True])
        with self.assertRaisesRegex(gymnasium.error.ResetNeeded, "after the last of 2 touches"):
            env.step(up)
        env.reset()
        env.step(up)

    def test_an_object_may_be_a_model(self):
        model = core.ObjectModel(core.load_known_object("box"))
        env = envs.TouchEnv(**QUICK | {"object": model})
        self.assertIs(env.model, model)
        env.reset(seed=1)

    def test_the_same_seed_and_actions_give_the_same(self):
        def play():
            env = gymnasium.make("palpate.envs:Palpate/Touch-v0", **QUICK)
            rows = [env.reset(seed=5)[0]["contacts"]]
            for azimuth in (0.0, 0.5, -0.5):
                observation, reward, *_ = env.step(np.array([azimuth, -0.5, 0.0]))
                rows.append([observation["probability"], reward])
            return rows

        for first, second in zip(play(), play()):
            np.testing.assert_array_equal(np.ravel(first[0]), np.ravel(second[0]))

    def test_touches_determine_the_pose(self):
        """Touches from all sides at half height are enough for a box on a table."""
        found = 0
        for seed in range(5):
            env = gymnasium.make("palpate.envs:Palpate/Touch-v0", object="box", max_touches=8)
            env.reset(seed=seed)
            for step in range(8):
                side = 0.3 * (-1) ** (step // 4)
                *_, terminated, truncated, info = env.step(np.array([step % 4 / 2 - 1, -0.7, side]))
                if terminated or truncated:
                    break
            found += info.get("correct", False)
        self.assertGreaterEqual(found, 3)

    def test_a_picture_shows_truth_estimate_and_contacts(self):
        env = gymnasium.make("palpate.envs:Palpate/Touch-v0", render_mode="rgb_array", **QUICK)
        env.reset(seed=1)
        first = env.render()
        self.assertEqual((first.shape, first.dtype), ((240, 480, 3), np.uint8))
        *_, info = env.step(np.array([0.0, -0.7, 0.0]))
        self.assertTrue(info["hit"])
        second = env.render()

        def pixels(picture, colour):
            return np.all(picture == colour, axis=2).sum()

        self.assertGreater(pixels(first, (190, 190, 190)), 500)
        self.assertEqual(pixels(first, (220, 40, 40)), 0)
        self.assertGreater(pixels(second, (220, 40, 40)), 3)
        self.assertGreater(pixels(second, (40, 90, 220)), 200)

    def test_observations_hold_no_truth(self):
        env = gymnasium.make("palpate.envs:Palpate/Touch-v0", **QUICK)
        observation, info = env.reset(seed=1)
        np.testing.assert_array_equal(observation["T_table_object"], np.eye(4))
        self.assertNotIn("truth", observation)
        self.assertEqual(info["truth"].shape, (4, 4))


@unittest.skipUnless(gymnasium and palpate, "gymnasium is not installed, or built without simulator")
class Pick(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.env = gymnasium.make("palpate.envs:Palpate/Pick-v0", object="box", max_steps=20).unwrapped

    def test_check_env_is_clean(self):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            check_env(self.env, skip_render_check=True)

    def test_the_hand_goes_where_it_is_commanded(self):
        observation, info = self.env.reset(seed=3)
        down = np.zeros(self.env.action_space.shape)
        down[0], down[2] = 1.0, -1.0
        for _ in range(20):
            observation, reward, terminated, truncated, info = self.env.step(down)
        self.assertTrue(truncated)
        self.assertFalse(terminated)
        np.testing.assert_allclose(observation["command"][[0, 2]], [0.3, 0.04], atol=1e-9)
        self.assertLess(abs(observation["mount"][0] - 0.3), 0.03)

    def test_what_cannot_be_done_is_refused(self):
        with self.assertRaisesRegex(gymnasium.error.ResetNeeded, "before the first reset"):
            PickEnv("box").step(np.zeros(26))
        with self.assertRaisesRegex(gymnasium.error.ResetNeeded, "before the first reset"):
            PickEnv("box", render_mode="rgb_array").render()
        for steps in (0, np.nan, 1.5):
            with self.assertRaisesRegex(ValueError, f"max_steps is {steps}, not"):
                PickEnv("box", max_steps=steps)
        self.env.reset(seed=1)
        for action in (np.full(self.env.action_space.shape, np.nan), np.zeros(2)):
            with self.assertRaisesRegex(ValueError, r"action of shape .*, not \(26,\)"):
                self.env.step(action)

    def test_observations_hold_no_truth(self):
        observation, info = self.env.reset(seed=1)
        self.assertEqual(info["truth"].shape, (4, 4))
        sensed = {"joints", "torques", "mount", "mount_force", "contacts", "command"}
        self.assertEqual(set(observation), sensed)
        self.assertEqual(observation["contacts"].max(), 0)

    def test_a_picture_is_of_its_size_and_shows_something(self):
        env = gymnasium.make("palpate.envs:Palpate/Pick-v0", max_steps=5, render_mode="rgb_array")
        env.reset(seed=1)
        try:
            first = env.render()
        except ValueError as error:
            self.skipTest(str(error))
        self.assertEqual((first.shape, first.dtype), ((360, 480, 3), np.uint8))
        self.assertGreater(first.std(), 5)
        down = np.zeros(env.action_space.shape)
        down[2] = -1.0
        for _ in range(4):
            env.step(down)
        self.assertTrue((env.render() != first).any())

    def test_lifting_is_rewarded_and_ends_the_episode(self):
        self.env.reset(seed=1)
        at_rest = self.env.world.truth()

        class Lifted:  # a world in which the object hangs 10 cm higher
            hand = self.env.world.hand

            def truth(self):
                return at_rest + 0.1 * np.outer(np.eye(4)[2], np.eye(4)[3])

        world, self.env.world = self.env.world, Lifted()
        try:
            still = np.zeros(self.env.action_space.shape)
            steps = [self.env.step(still) for _ in range(10)]
        finally:
            self.env.world = world
        self.assertAlmostEqual(steps[0][1], 0.1, delta=0.002)
        self.assertEqual([step[2] for step in steps], [False] * 9 + [True])
        self.assertTrue(steps[0][4]["lifted"])


@unittest.skipUnless(gymnasium and palpate, "gymnasium is not installed, or built without simulator")
class Goals(unittest.TestCase):
    """Place-v0 and Reorient-v0: the object is to be at a target."""

    @classmethod
    def setUpClass(cls):
        cls.place = gymnasium.make("palpate.envs:Palpate/Place-v0", object="box", max_steps=15).unwrapped
        cls.turn = gymnasium.make("palpate.envs:Palpate/Reorient-v0", max_steps=15).unwrapped

    def put(self, env, pose):
        """The environment with its object somewhere else."""

        class Moved:
            hand, T_world_mount = env.world.hand, env.world.T_world_mount

            def truth(self):
                return pose

        world, env.world = env.world, Moved()
        self.addCleanup(setattr, env, "world", world)

    def test_check_env_is_clean(self):
        for env in (self.place, self.turn):
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                check_env(env, skip_render_check=True)

    def test_the_target_is_some_way_off_and_upright(self):
        for seed in range(5):
            observation, info = self.place.reset(seed=seed)
            self.assertGreater(info["translation_error_mm"], 79)
            self.assertLess(info["translation_error_mm"], 151)
            target = observation["target"]
            self.assertAlmostEqual(target[2, 3], info["truth"][2, 3], delta=1e-3)
            np.testing.assert_allclose(target[2, :3], info["truth"][2, :3], atol=1e-12)

    def test_an_object_may_be_a_model(self):
        self.assertIs(PlaceEnv(self.place.model).model, self.place.model)

    def test_an_object_at_its_target_ends_the_episode(self):
        self.place.reset(seed=2)
        self.put(self.place, self.place.target)
        still = np.zeros(self.place.action_space.shape)
        steps = [self.place.step(still) for _ in range(10)]
        self.assertGreater(steps[0][1], 0.079)  # m nearer
        self.assertEqual([step[2] for step in steps], [False] * 9 + [True])
        self.assertTrue(steps[-1][4]["reached"])

    def test_reorienting_starts_with_the_object_in_the_hand(self):
        observation, info = self.turn.reset(seed=4)
        self.assertGreater(info["truth"][2, 3], 0.08)
        self.assertGreater(np.count_nonzero(observation["contacts"][:, 6:].any(axis=1)), 1)
        self.assertLess(info["translation_error_mm"], 1)
        self.assertTrue(5 < info["rotation_error_deg"] <= 40.1, info)
        still = np.zeros(self.turn.action_space.shape)
        for _ in range(5):
            *_, terminated, truncated, info = self.turn.step(still)
        self.assertFalse(info["dropped"])

    def test_what_falls_ends_the_episode(self):
        self.turn.reset(seed=5)
        fallen = self.turn.world.truth()
        fallen[2, 3] -= 0.06
        self.put(self.turn, fallen)
        *_, terminated, truncated, info = self.turn.step(np.zeros(self.turn.action_space.shape))
        self.assertTrue(terminated and info["dropped"] and not info["reached"])


if __name__ == "__main__":
    unittest.main()
