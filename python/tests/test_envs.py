# SPDX-License-Identifier: Apache-2.0
"""The environments, where gymnasium is installed."""

import unittest
import warnings

import numpy as np

try:
    import gymnasium
    from gymnasium.utils.env_checker import check_env
except ImportError:
    gymnasium = None

try:
    import palpate.sim
except ImportError:
    palpate = None

QUICK = {"object": "box", "max_touches": 6, "proposals": 2000, "particles": 60}


@unittest.skipUnless(gymnasium, "gymnasium is not installed")
class Touch(unittest.TestCase):
    def test_check_env_is_clean(self):
        env = gymnasium.make("palpate:Palpate/Touch-v0", **QUICK)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            check_env(env.unwrapped, skip_render_check=True)

    def test_the_same_seed_and_actions_give_the_same(self):
        def play():
            env = gymnasium.make("palpate:Palpate/Touch-v0", **QUICK)
            rows = [env.reset(seed=5)[0]["contacts"]]
            for azimuth in (0.0, 0.5, -0.5):
                observation, reward, *_ = env.step(np.array([azimuth, -0.5, 0.0]))
                rows.append([observation["probability"], reward])
            return rows

        for first, second in zip(play(), play()):
            np.testing.assert_array_equal(np.ravel(first[0]), np.ravel(second[0]))

    def test_touches_tell_the_pose(self):
        """Touches from all sides at half height are enough for a box on a table."""
        found = 0
        for seed in range(5):
            env = gymnasium.make("palpate:Palpate/Touch-v0", object="box", max_touches=8)
            env.reset(seed=seed)
            for step in range(8):
                side = 0.3 * (-1) ** (step // 4)
                *_, terminated, truncated, info = env.step(np.array([step % 4 / 2 - 1, -0.7, side]))
                if terminated or truncated:
                    break
            found += info.get("correct", False)
        self.assertGreaterEqual(found, 3)

    def test_observations_hold_no_truth(self):
        env = gymnasium.make("palpate:Palpate/Touch-v0", **QUICK)
        observation, info = env.reset(seed=1)
        np.testing.assert_array_equal(observation["T_table_object"], np.eye(4))
        self.assertNotIn("truth", observation)
        self.assertEqual(info["truth"].shape, (4, 4))


@unittest.skipUnless(gymnasium and palpate, "gymnasium is not installed, or built without simulator")
class Pick(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.env = gymnasium.make("palpate:Palpate/Pick-v0", object="box", max_steps=20).unwrapped

    def test_check_env_is_clean(self):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            check_env(self.env, skip_render_check=True)

    def test_the_hand_goes_where_it_is_told(self):
        observation, info = self.env.reset(seed=3)
        down = np.zeros(self.env.action_space.shape)
        down[0], down[2] = 1.0, -1.0
        for _ in range(20):
            observation, reward, terminated, truncated, info = self.env.step(down)
        self.assertTrue(truncated)
        self.assertFalse(terminated)
        np.testing.assert_allclose(observation["command"][[0, 2]], [0.3, 0.04], atol=1e-9)
        self.assertLess(abs(observation["base"][0] - 0.3), 0.03)

    def test_observations_hold_no_truth(self):
        observation, info = self.env.reset(seed=1)
        self.assertEqual(info["truth"].shape, (4, 4))
        sensed = {"joints", "torques", "base", "base_force", "contacts", "command"}
        self.assertEqual(set(observation), sensed)
        self.assertEqual(observation["contacts"].max(), 0)

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


if __name__ == "__main__":
    unittest.main()
