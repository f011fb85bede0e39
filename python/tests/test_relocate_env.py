# SPDX-License-Identifier: Apache-2.0
"""The environment Relocate-v2, alone and as a vector, where gymnasium is installed."""

import threading
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


@unittest.skipUnless(gymnasium and palpate, "gymnasium is not installed, or built without simulator")
class Relocate(unittest.TestCase):
    ID, QUICK = "palpate.envs:Palpate/Relocate-v2", {"solver": "fast", "horizon": 8}

    def test_check_env_is_clean(self):
        for flat in (False, True):
            env = gymnasium.make(self.ID, flat=flat, **self.QUICK)
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                check_env(env.unwrapped, skip_render_check=True)

    def test_a_vector_is_as_many_environments_bit_for_bit(self):
        def vector(mode):
            return gymnasium.make_vec(self.ID, 3, vectorization_mode=mode, **self.QUICK)

        ours, theirs = vector("vector_entry_point"), vector("sync")
        for env in (ours, theirs):
            env.action_space.seed(1)
        rows = [(env.reset(seed=11)) for env in (ours, theirs)]
        for step in range(20):  # two ends of episodes are among them
            for name in ("joints", "palm_from_object", "object_from_target", "velocities"):
                np.testing.assert_array_equal(rows[0][0][name], rows[1][0][name])
            for name in ("truth", "distance", "contact"):
                np.testing.assert_array_equal(rows[0][-1][name], rows[1][-1][name])
                self.assertEqual(rows[0][-1][name].dtype, rows[1][-1][name].dtype)
            if step:
                for mine, other in zip(rows[0][1:4], rows[1][1:4]):
                    np.testing.assert_array_equal(mine, other)
            actions = ours.action_space.sample()
            rows = [env.step(actions) for env in (ours, theirs)]

    def test_seeds_may_be_as_large_as_gymnasium_s(self):
        large = 2**100 + 7
        env = gymnasium.make(self.ID, **self.QUICK)
        truths = [env.reset(seed=seed)[1]["truth"] for seed in (large, 7)]
        np.testing.assert_array_equal(*truths)
        vector = gymnasium.make_vec(self.ID, 2, vectorization_mode="vector_entry_point", **self.QUICK)
        np.testing.assert_array_equal(vector.reset(seed=large)[1]["truth"][0], truths[0])

    def test_the_start_can_be_given(self):
        env = gymnasium.make(self.ID, **self.QUICK)
        start = {"object": [-0.05, 0.02], "target": [-0.1, 0.0, 0.2]}
        observation, info = env.reset(seed=1, options=start)
        np.testing.assert_allclose(info["target"], start["target"])
        offset = observation["object_from_target"]
        self.assertAlmostEqual(np.linalg.norm(offset), info["distance"])
        other, _ = env.reset(seed=2, options=start)
        np.testing.assert_array_equal(other["object_from_target"], offset)

    def test_refuses_with_the_value(self):
        with self.assertRaisesRegex(ValueError, "no_solver"):
            gymnasium.make(self.ID, solver="no_solver")
        with self.assertRaisesRegex(ValueError, "are object and target, not objekt"):
            gymnasium.make(self.ID, **self.QUICK).reset(options={"objekt": [0, 0]})
        with self.assertRaisesRegex(gymnasium.error.ResetNeeded, "before the first reset"):
            gymnasium.make(self.ID, **self.QUICK).unwrapped.step(np.zeros(30))
        vector = gymnasium.make_vec(self.ID, 2, vectorization_mode="vector_entry_point", **self.QUICK)
        with self.assertRaisesRegex(gymnasium.error.ResetNeeded, "before the first reset"):
            vector.step(np.zeros((2, 30)))
        tasks = palpate.sim.RelocateTasks(2, options={"solver": "fast"})
        with self.assertRaisesRegex(ValueError, r"actions has shape \(2, 29\), not \(2, 30\)"):
            tasks.step(np.zeros((2, 29)))
        with self.assertRaisesRegex(IndexError, "no task 2 of 2"):
            tasks.reset(2, 0)

    def test_threads_take_turns_with_the_tasks(self):
        tasks = palpate.sim.RelocateTasks(3, threads=2, options={"solver": "fast"})
        alone = palpate.sim.RelocateTasks(3, options={"solver": "fast"})
        for one in (tasks, alone):
            for index in range(3):
                one.reset(index, 7 + index)

        def step():
            for _ in range(10):
                tasks.step(np.full((3, 30), 0.1))
                self.assertEqual(tasks.observations.shape, (3, 39))

        threads = [threading.Thread(target=step) for _ in range(3)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        for _ in range(30):
            alone.step(np.full((3, 30), 0.1))
        np.testing.assert_array_equal(tasks.positions, alone.positions)

    def test_a_picture_shows_each_task_and_its_target(self):
        def make(mode):
            return gymnasium.make_vec(self.ID, 2, vectorization_mode=mode,
                                      render_mode="rgb_array", **self.QUICK)

        ours = make("vector_entry_point")
        with self.assertRaisesRegex(gymnasium.error.ResetNeeded, "before the first reset"):
            ours.render()
        ours.reset(seed=1)
        try:
            first = ours.render()
        except ValueError as error:
            self.skipTest(str(error))
        self.assertEqual([(one.shape, one.dtype) for one in first], [((360, 480, 3), np.uint8)] * 2)
        self.assertGreater(first[0].std(), 5)
        self.assertTrue((first[0] != first[1]).any())
        for _ in range(5):
            ours.step(np.ones((2, 30)))
        self.assertTrue((ours.render()[0] != first[0]).any())
        theirs = make("sync")
        theirs.reset(seed=1)
        for one, other in zip(first, theirs.render()):
            np.testing.assert_array_equal(one, other)
        env = gymnasium.make(self.ID, render_mode="rgb_array", **self.QUICK).unwrapped
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            check_env(env)
        start, views = {"object": [-0.05, 0.02]}, []
        for target in ([-0.1, 0.0, 0.2], [0.1, 0.0, 0.3]):
            env.reset(seed=1, options=start | {"target": target})
            views.append(env.render())
        self.assertTrue((views[0] != views[1]).any())
        with self.assertRaisesRegex(IndexError, "no task 2 of 2"):
            ours.tasks.render(2)
        with self.assertRaisesRegex(ValueError, "8 x 360 pixels"):
            ours.tasks.render(0, width=8)

    def test_an_action_that_is_not_finite_ends_the_episode(self):
        env = gymnasium.make(self.ID, **self.QUICK).unwrapped
        env.reset(seed=1)
        *_, terminated, truncated, info = env.step(np.full(30, np.nan))
        self.assertTrue(terminated and not truncated)


if __name__ == "__main__":
    unittest.main()
