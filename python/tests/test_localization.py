# SPDX-License-Identifier: Apache-2.0
"""The pose of a box from contacts: posterior, prior evidence, tracker, and the next touch."""

import pathlib
import tempfile
import unittest

import numpy as np
import palpate
from box_contacts import box_points


class Localization(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.model = palpate.ObjectModel(palpate.load_known_object("box"))
        cls.truth = np.eye(4)
        cls.truth[:3, :3] = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
        cls.truth[:3, 3] = [0.4, -0.1, 0.2]
        cls.points, cls.normals = box_points(18)
        cls.contacts = palpate.Contacts(cls.points, cls.normals).transformed(cls.truth)

    def test_finds_the_pose(self):
        posterior = palpate.localize(self.model, self.contacts)
        self.assertEqual(posterior.status, "certain")
        rotation, translation = posterior.error(self.truth)
        self.assertLess(np.degrees(rotation), 3)
        self.assertLess(translation, 0.003)
        self.assertTrue(posterior.covers(self.truth))
        self.assertGreater(posterior.probability, 0.95)
        self.assertEqual(posterior.best.covariance.shape, (6, 6))

    def test_contacts_without_normals(self):
        points, _ = box_points(40)
        bare = palpate.Contacts(points).transformed(self.truth)
        self.assertIsNone(bare.normals)
        rotation, translation = palpate.localize(self.model, bare).error(self.truth)
        self.assertLess(np.degrees(rotation), 5)
        self.assertLess(translation, 0.010)

    def test_a_file_without_normals_is_localized_with_its_own_errors(self):
        points = palpate.Contacts(box_points(40)[0]).transformed(self.truth).points
        rows = [f"{x},{y},{z},{0.001 + 0.0001 * i}" for i, (x, y, z) in enumerate(points)]
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "touched.csv"
            path.write_text("\n".join(["x,y,z,point_sigma", *rows]))
            contacts = palpate.read_contacts(path)
        self.assertIsNone(contacts.normals)
        np.testing.assert_allclose(contacts.points, points, atol=1e-12)
        np.testing.assert_allclose(contacts.point_sigma, 0.001 + 0.0001 * np.arange(40))
        rotation, translation = palpate.localize(self.model, contacts).error(self.truth)
        self.assertLess(np.degrees(rotation), 5)
        self.assertLess(translation, 0.010)

    def test_samples_are_spread_as_the_mode_says(self):
        posterior = palpate.localize(self.model, self.contacts)
        samples = posterior.sample(4000, seed=3)
        self.assertEqual(samples.shape, (4000, 4, 4))
        np.testing.assert_array_equal(samples, posterior.sample(4000, seed=3))
        self.assertFalse(np.array_equal(samples, posterior.sample(4000, seed=4)))
        np.testing.assert_allclose(samples[:, 3], np.tile([0, 0, 0, 1], (4000, 1)))
        best = posterior.best
        self.assertGreater(best.weight, 0.99)
        places = samples[:, :3, 3] - best.T_frame_object[:3, 3]
        near = places[np.linalg.norm(places, axis=1) < 0.02]
        self.assertGreater(len(near), 0.98 * 4000)
        deviations = np.sqrt(np.diag(best.covariance)[3:])
        np.testing.assert_allclose(near.std(axis=0), deviations, rtol=0.1)
        for count in (0, -1, 10**7):
            with self.assertRaisesRegex(ValueError, "count is"):
                posterior.sample(count)

    def test_pose_error_is_modulo_symmetry(self):
        half_turn = self.truth @ np.diag([1.0, -1, -1, 1])
        half_turn[:3, 3] += [0.003, 0, -0.004]
        rotation, translation = palpate.pose_error(self.model, half_turn, self.truth)
        self.assertAlmostEqual(rotation, 0, places=6)
        self.assertAlmostEqual(translation, 0.005)
        with self.assertRaisesRegex(ValueError, "estimate"):
            palpate.pose_error(self.model, np.eye(3), self.truth)

    def test_free_voxels_are_balls_inside_them(self):
        free = np.zeros((5, 4, 4), bool)
        free[:4] = True
        free[4, 0, 0] = True
        balls = palpate.free_space_of_voxels(free, 0.01, self.truth)
        np.testing.assert_allclose(sorted(balls[:, 3]), [0.005, 0.02])
        at_origin = palpate.free_space_of_voxels(free, 0.01)
        largest = at_origin[np.argmax(at_origin[:, 3])]
        np.testing.assert_allclose(largest, [0.02, 0.02, 0.02, 0.02])
        np.testing.assert_allclose(at_origin[0], [0.045, 0.005, 0.005, 0.005])
        moved = at_origin[:, :3] @ self.truth[:3, :3].T + self.truth[:3, 3]
        np.testing.assert_allclose(balls[:, :3], moved)
        for wrong, word in (((free[0], 0.01), r"\(4, 4\), not"), ((free, 0.0), "pitch is 0 m")):
            with self.assertRaisesRegex(ValueError, word):
                palpate.free_space_of_voxels(*wrong)

    def test_free_voxels_rule_out_what_would_stand_in_them(self):
        """A box on a table may stand upright, but not where the air above it was seen."""
        T_frame_grid = np.eye(4)
        T_frame_grid[:3, 3] = [-0.1, -0.1, 0.12]
        air = palpate.free_space_of_voxels(np.ones((20, 20, 8), bool), 0.01, T_frame_grid)
        touch = palpate.Contacts([[0.03, 0, 0.02]], [[1, 0, 0]])
        upright = [
            sum(mode.weight for mode in palpate.localize(
                self.model, touch, table=palpate.TableSupport(np.eye(4)), free_space=free,
                proposals=8000, particles=200).modes
                if mode.T_frame_object[2, 3] > 0.08)
            for free in (None, air)
        ]  # fmt: skip
        self.assertGreater(upright[0], 0.01)
        self.assertEqual(upright[1], 0)

    def test_candidates_of_which_one_touches(self):
        contacts = palpate.Contacts(np.empty((0, 3)))
        random = np.random.default_rng(5)
        for p, n in zip(self.points, self.normals):
            patch = p + 0.01 * np.vstack([np.zeros(3), random.standard_normal((2, 3))])
            contacts = contacts + palpate.Contacts(patch, np.tile(n, (3, 1))).candidates()
        self.assertEqual(sorted(set(contacts.groups)), list(range(18)))
        posterior = palpate.localize(self.model, contacts.transformed(self.truth))
        rotation, translation = posterior.error(self.truth)
        self.assertLess(np.degrees(rotation), 5)
        self.assertLess(translation, 0.010)

    def test_the_same_seed_gives_the_same(self):
        few = palpate.Contacts(self.points[:4], self.normals[:4])
        first, second = (palpate.localize(self.model, few, seed=3) for _ in range(2))
        np.testing.assert_array_equal(first.best.T_frame_object, second.best.T_frame_object)
        self.assertEqual([m.weight for m in first.modes], [m.weight for m in second.modes])

    def test_prior_table_and_free_space_are_heard(self):
        few = palpate.Contacts(self.points[:3], self.normals[:3]).transformed(self.truth)
        alone = palpate.localize(self.model, few)
        prior = palpate.prior_from(palpate.localize(self.model, self.contacts), floor=1e-9)
        informed = palpate.localize(self.model, few, prior=prior)
        self.assertGreater(informed.probability, alone.probability + 0.3)
        table = palpate.TableSupport(np.eye(4), half_width=0.05)
        resting = palpate.localize(self.model, palpate.Contacts(np.empty((0, 3))), table=table)
        heights = [pose.height for pose in self.model.object.stable_poses]
        for mode in resting.modes:
            self.assertLess(min(abs(mode.T_frame_object[2, 3] - h) for h in heights), 0.005)
        with self.assertRaisesRegex(ValueError, r"not \(N, 4\)"):
            palpate.localize(self.model, few, free_space=[[0, 0, 0]])

    def test_a_table_keeps_what_it_was_given(self):
        values = {"half_width": 0.05, "tilt_sigma": 0.03, "height_sigma": 0.002,
                  "edge_sigma": 0.004, "surface_sigma": 0.0005, "centroid_sigma": 0.003}  # fmt: skip
        table = palpate.TableSupport(self.truth, **values)
        self.assertEqual({name: getattr(table, name) for name in values}, values)
        np.testing.assert_allclose(table.T_frame_table, self.truth, atol=1e-12)
        with self.assertRaisesRegex(ValueError, "surface_sigma is -1"):
            palpate.TableSupport(self.truth, surface_sigma=-1)

    def test_planes_are_heard(self):
        """Where the object ends along each axis settles what three contacts leave open."""
        few = palpate.Contacts(self.points[:3], self.normals[:3]).transformed(self.truth)
        vertices = self.model.object.mesh.vertices @ self.truth[:3, :3].T + self.truth[:3, 3]
        axes = np.vstack([np.eye(3), -np.eye(3)])
        planes = np.column_stack([axes, (vertices @ axes.T).min(axis=0)])
        alone = palpate.localize(self.model, few)
        informed = palpate.localize(self.model, few, planes=planes)
        self.assertGreater(informed.probability, alone.probability + 0.3)
        rotation, translation = informed.error(self.truth)
        self.assertLess(np.degrees(rotation), 5)
        self.assertLess(translation, 0.005)
        for wrong, words in ([[[0, 0, 1]], r"not \(N, 4\) or"], [[[0, 0, 2, 0]], "length 2"],
                             [[[0, 0, 1, 0, -1]], "sigma is -1"]):  # fmt: skip
            with self.assertRaisesRegex(ValueError, words):
                palpate.localize(self.model, few, planes=wrong)

    def test_what_is_known_of_another_object_is_refused(self):
        found = palpate.localize(self.model, self.contacts)
        prior = palpate.prior_from(found)
        self.assertEqual(repr(prior), "PosePrior('box', 1 components)")
        cube = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]) * 0.05
        sides = [[0, 1, 3], [0, 3, 2], [4, 7, 5], [4, 6, 7], [0, 5, 1], [0, 4, 5],
                 [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]  # fmt: skip
        other = palpate.ObjectModel(palpate.make_known_object("cube", palpate.Mesh(cube, sides)))
        with self.assertRaisesRegex(ValueError, "the prior is of 'box', not 'cube'"):
            palpate.localize(other, self.contacts, prior=prior)
        touch = palpate.TouchAction([0.2, 0, 0.05], [-1, 0, 0])
        with self.assertRaisesRegex(ValueError, "the posterior is of 'box', not 'cube'"):
            palpate.choose_touch(other, found, [touch])

    def test_no_pose_is_a_status(self):
        posterior = palpate.localize(self.model, palpate.Contacts(np.empty((0, 3))))
        self.assertEqual((posterior.status, posterior.best, posterior.modes), ("no_pose", None, []))
        with self.assertRaisesRegex(ValueError, "no pose"):
            posterior.sample(1)

    def test_tracker_follows_a_shift(self):
        start = palpate.localize(self.model, self.contacts)
        for normals in (self.normals, None):
            tracker = palpate.Tracker(self.model, start, seed=1)
            T = self.truth.copy()
            for frame in range(11):
                T[:3, 3] = self.truth[:3, 3] + [0.001 * frame, 0, 0]
                now = palpate.Contacts(self.points, normals).transformed(T)
                velocity = np.tile([0.1, 0, 0], (len(now), 1))
                posterior = tracker.update(0.01 * frame, now, velocity)
            self.assertLess(posterior.error(T)[1], 0.002)
        before = posterior.best.T_frame_object
        late = tracker.update(0.05, palpate.Contacts([[1, 1, 1]]), [[0, 0, 0]])  # out of order
        np.testing.assert_array_equal(late.best.T_frame_object, before)
        with self.assertRaisesRegex(ValueError, "velocities"):
            tracker.update(1.0, now, velocity[:2])

    def test_the_next_touch(self):
        few = palpate.Contacts(self.points[:3], self.normals[:3])
        posterior = palpate.localize(self.model, few)
        actions = [palpate.TouchAction([0.5, 0, 0], [1, 0, 0]),  # away from the object
                   palpate.TouchAction([0.2, 0, 0.05], [-1, 0, 0])]  # fmt: skip
        index, information = palpate.choose_touch(self.model, posterior, actions)
        self.assertEqual(index, 1)
        self.assertGreater(information, 0)
        hit = palpate.predict_touch(self.model, np.eye(4), actions[1], tip_radius=0.01)
        self.assertAlmostEqual(hit.distance, 0.2 - 0.025 - 0.01, places=4)


if __name__ == "__main__":
    unittest.main()
