# SPDX-License-Identifier: Apache-2.0
"""The package as a user meets it: typed, frozen, in numpy's terms."""

import pathlib
import tempfile
import threading
import unittest

import numpy as np
import palpate
from box_contacts import BOX, box_points

class Geometry(unittest.TestCase):
    def test_closest_points(self):
        box = palpate.load_known_object("box")
        closest = box.mesh.closest_points([[0.1, 0, 0], [0, 0.2, 0]])
        np.testing.assert_allclose(closest.points, [[0.025, 0, 0], [0, 0.047, 0]], atol=1e-6)
        np.testing.assert_allclose(closest.normals, [[1, 0, 0], [0, 1, 0]], atol=1e-6)
        np.testing.assert_allclose(closest.distances, [0.075, 0.153], atol=1e-6)
        np.testing.assert_allclose(box.mesh.signed_distance([[0, 0, 0]]), [-0.025], atol=1e-6)

    def test_mesh_goes_in_and_out(self):
        box = palpate.load_known_object("box").mesh
        again = palpate.Mesh(box.vertices, box.triangles)
        np.testing.assert_array_equal(again.vertices, box.vertices)
        self.assertAlmostEqual(again.area, box.area)
        with self.assertRaisesRegex(ValueError, "vertices 0, 1, 99 of 8"):
            palpate.Mesh(box.vertices[:8], [[0, 1, 99]])

    def test_object(self):
        box = palpate.load_known_object("box")
        self.assertAlmostEqual(box.volume, np.prod(BOX), places=8)
        self.assertEqual(box.T_mesh_object.shape, (4, 4))
        self.assertTrue(box.T_mesh_object.flags.c_contiguous)
        self.assertEqual(len(box.symmetries), 4)
        self.assertAlmostEqual(sum(pose.probability for pose in box.stable_poses), 1)
        with self.assertRaisesRegex(ValueError, "nothing_like_it"):
            palpate.load_known_object("nothing_like_it")


class Registration(unittest.TestCase):
    def setUp(self):
        random = np.random.default_rng(2)
        self.source = random.uniform(-0.1, 0.1, (60, 3))
        self.truth = np.eye(4)
        self.truth[:3, :3] = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
        self.truth[:3, 3] = [0.3, 0.2, -0.1]
        self.target = self.source @ self.truth[:3, :3].T + self.truth[:3, 3]
        self.target[20:] = random.uniform(-0.2, 0.2, (40, 3))

    def test_finds_the_pose_among_outliers(self):
        result = palpate.register_correspondences(self.source, self.target, bound_nodes=10000)
        self.assertEqual(result.status, "found")
        np.testing.assert_allclose(result.T_target_source, self.truth, atol=1e-9)
        self.assertTrue(set(range(20)) <= set(result.inliers))
        self.assertTrue(result.certificate.least_squares)
        self.assertGreaterEqual(result.certificate.robust_bound.max_inliers, len(result.inliers))
        self.assertLess(result.false_alarms, 1e-6)
        self.assertEqual(result.covariance.shape, (6, 6))

    def test_runner_up_and_instances(self):
        second = self.truth.copy()
        second[:3, 3] = [-1, 2, 0]
        self.target[20:32] = self.source[20:32] @ second[:3, :3].T + second[:3, 3]
        result = palpate.register_correspondences(self.source, self.target, instances=2)
        self.assertEqual(len(result.instances), 1)
        np.testing.assert_allclose(result.instances[0].T_target_source, second, atol=1e-9)
        self.assertGreaterEqual(result.runner_up.inliers, 12)

    def test_free_motions(self):
        line = np.outer(np.linspace(0, 0.1, 30), [1, 0, 0])
        result = palpate.register_correspondences(line, line)
        self.assertEqual(result.status, "degenerate")
        self.assertEqual([m.kind for m in result.free_motions], ["rotation"])
        self.assertAlmostEqual(abs(result.free_motions[0].direction[0]), 1, places=6)

    def test_clouds_by_features_of_ones_own(self):
        random = np.random.default_rng(5)
        points = random.uniform(-0.1, 0.1, (800, 3)) * [1, 0.7, 0.4]
        moved = points @ self.truth[:3, :3].T + self.truth[:3, 3]
        source, target = palpate.PointCloud(points), palpate.PointCloud(moved)
        found = palpate.register_described(source, points, target, points, voxel=0.01)
        np.testing.assert_allclose(found.result.T_target_source, self.truth, atol=1e-6)
        upright = palpate.register_described(source, points, target, points, voxel=0.01,
                                             rotation_axis=[0, 0, 2])
        np.testing.assert_allclose(upright.result.T_target_source, self.truth, atol=1e-6)
        with self.assertRaisesRegex(ValueError, "10 features"):
            palpate.register_described(source, points[:10], target, points, voxel=0.01)

    def test_unknown_scale(self):
        result = palpate.register_correspondences(2.5 * self.source, self.target)
        self.assertEqual(result.status, "no_consensus")
        result = palpate.register_correspondences(2.5 * self.source, self.target,
                                                  estimate_scale=True)
        self.assertAlmostEqual(result.scale, 0.4, places=9)
        np.testing.assert_allclose(result.T_target_source, self.truth, atol=1e-9)

    def test_primitive(self):
        plane = self.source.copy()
        plane[:, 2] = 0
        normals = np.tile([0.0, 0, 1], (len(plane), 1))
        arguments = {"source_normals": normals, "target_normals": normals}
        result = palpate.register_correspondences(plane, plane, **arguments)
        self.assertEqual(result.status, "found")
        result = palpate.register_correspondences(plane, plane, primitive="plane", **arguments)
        self.assertEqual(result.status, "degenerate")
        self.assertEqual(len(result.free_motions), 3)
        with self.assertRaisesRegex(ValueError, "'line' is neither 'point' nor 'plane'"):
            palpate.register_correspondences(plane, plane, primitive="line", **arguments)

    def test_no_consensus_is_a_status(self):
        result = palpate.register_correspondences(self.source[20:], self.target[20:])
        self.assertEqual(result.status, "no_consensus")
        self.assertIsNone(result.T_target_source)

    def test_certify(self):
        good = palpate.certify(self.truth, self.source[:20], self.target[:20])
        self.assertEqual(good.status, "certified")
        off = self.truth.copy()
        off[0, 3] += 0.01
        worse = palpate.certify(off, self.source[:20], self.target[:20])
        self.assertEqual(worse.status, "uncertified")
        self.assertAlmostEqual(worse.cost, 20 * 0.01**2, places=9)

    def test_certify_planes(self):
        points, normals = np.random.default_rng(5).uniform(-1, 1, (2, 20, 3))
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        pairs = {"target_normals": normals, "source_normals": normals, "primitive": "plane"}
        self.assertEqual(palpate.certify(np.eye(4), points, points, **pairs).status, "certified")
        off = np.eye(4)
        off[0, 3] = 0.01
        worse = palpate.certify(off, points, points, **pairs)
        self.assertEqual(worse.status, "uncertified")
        self.assertAlmostEqual(worse.cost, np.sum((0.01 * normals[:, 0]) ** 2), places=9)
        with self.assertRaisesRegex(ValueError, "normals"):
            palpate.certify(np.eye(4), points, points, primitive="plane")

    def test_refuses_with_the_value(self):
        with self.assertRaisesRegex(ValueError, r"source has shape \(60, 2\), not \(N, 3\)"):
            palpate.register_correspondences(self.source[:, :2], self.target)
        with self.assertRaisesRegex(ValueError, "noise bound -1 m"):
            palpate.register_correspondences(self.source, self.target, noise_bound=-1)
        self.target[3, 1] = np.nan
        with self.assertRaisesRegex(ValueError, "3"):
            palpate.register_correspondences(self.source, self.target)


class Clouds(unittest.TestCase):
    """Of the duck, whose poses are told by how far they put its points from its surface."""

    @classmethod
    def setUpClass(cls):
        cls.mesh = palpate.load_known_object("duck").mesh
        with tempfile.TemporaryDirectory() as folder:
            cls.mesh.save(f"{folder}/duck.ply")
            first, second = (palpate.load_cloud(f"{folder}/duck.ply", samples=n).points
                             for n in (6000, 8000))
        cls.turn = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
        cls.source = palpate.PointCloud(first)
        cls.target = palpate.PointCloud(second @ cls.turn.T + [0.3, 0.2, -0.1])

    def gaps(self, T, scale, source, at):
        """Of the placed source's points from the duck whose origin is there, m."""
        placed = scale * source.points @ T[:3, :3].T + T[:3, 3]
        return self.mesh.closest_points((placed - at) @ self.turn).distances

    def test_pose_and_pairs(self):
        found = palpate.register_clouds(self.source, self.target)
        self.assertEqual(found.result.status, "found")
        T = found.result.T_target_source
        self.assertLess(self.gaps(T, 1, self.source, [0.3, 0.2, -0.1]).mean(), 0.001)
        self.assertGreater(found.feature_matches, 50)
        self.assertGreater(found.feature_inliers, 10)
        self.assertLess(found.feature_inliers, found.feature_matches)
        self.assertGreater(found.refinements, 0)
        apart = np.linalg.norm(found.source @ T[:3, :3].T + T[:3, 3] - found.target, axis=1)
        np.testing.assert_allclose(apart, found.result.residuals, atol=1e-9)
        none = palpate.register_clouds(self.source, self.target, max_false_alarms=1e-300)
        self.assertEqual(none.result.status, "no_consensus")
        best = palpate.register_clouds(self.source, self.target, max_false_alarms=1e-300,
                                       best_effort=True, primitive="point")
        self.assertEqual(best.result.status, "found")

    def test_unknown_scale(self):
        small = palpate.PointCloud(0.02 * self.source.points)
        self.assertIsNone(palpate.register_clouds(small, self.target).result.T_target_source)
        result = palpate.register_clouds(small, self.target, estimate_scale=True).result
        self.assertAlmostEqual(result.scale, 50, delta=0.1)
        gaps = self.gaps(result.T_target_source, result.scale, small, [0.3, 0.2, -0.1])
        self.assertLess(gaps.mean(), 0.001)
        with self.assertRaisesRegex(ValueError, "scale excludes instances"):
            palpate.register_clouds(small, self.target, estimate_scale=True, instances=2)

    def test_instances(self):
        places = ([0.3, 0.2, -0.1], [0.3, 0.5, -0.1])
        scene = palpate.PointCloud(np.concatenate(
            [self.target.points, self.target.points + [0, 0.3, 0]]))
        result = palpate.register_clouds(self.source, scene, instances=3).result
        self.assertEqual(len(result.instances), 1)
        poses = [result.T_target_source, result.instances[0].T_target_source]
        fits = [[bool(self.gaps(T, 1, self.source, at).mean() < 0.001) for at in places]
                for T in poses]
        self.assertIn(fits, ([[True, False], [False, True]], [[False, True], [True, False]]))

    def test_refuses_with_the_value(self):
        with self.assertRaisesRegex(ValueError, "0 instances"):
            palpate.register_clouds(self.source, self.target, instances=0)
        with self.assertRaisesRegex(ValueError, "noise bound"):
            palpate.register_clouds(self.source, self.target, noise_bound=np.nan)


class Contacts(unittest.TestCase):
    def test_refuses_with_the_value(self):
        for arguments, words in (
            (([[0, 0]],), r"points has shape \(1, 2\), not \(N, 3\)"),
            (([[0, 0, np.inf]],), "contact 0: point is"),
            (([[0, 0, 0]], [[1, 0, 0], [0, 1, 0]]), "normals: 2 for 1 points"),
            (([[0, 0, 0]], None, None, -0.5), "contact 0: point_sigma is -0.5"),
            (([[0, 0, 0]], None, None, [1, 2]), r"point_sigma has shape \(2,\)"),
            (("far",), "points: could not convert string to float: 'far'"),
        ):
            with self.assertRaisesRegex(ValueError, words):
                palpate.Contacts(*arguments)

    def test_rows_of_nan_are_unknown_normals(self):
        contacts = palpate.Contacts(np.zeros((2, 3)), [[0, 0, 2], [np.nan] * 3])
        np.testing.assert_array_equal(contacts.normals, [[0, 0, 1], [np.nan] * 3])
        self.assertEqual(len(contacts), 2)

    def test_height_map_of_a_ball(self):
        radius, press, pixel = 0.02, 0.001, 5e-5
        y, x = (np.indices((240, 320)).T - [119.5, 159.5]).T * pixel
        depth = np.maximum(0, press - radius + np.sqrt(radius**2 - x**2 - y**2))
        contacts = palpate.contacts_of_height_map(depth, pixel)
        arms = contacts.points - [0, 0, radius - press]
        np.testing.assert_allclose(np.linalg.norm(arms, axis=1), radius, atol=3e-5)
        self.assertGreater(np.min(np.sum(contacts.normals * arms, axis=1) / radius), 0.999)

    def test_taxels_and_wrench(self):
        skin = palpate.contacts_of_taxels([[0, 0, 0], [0, 0.01, 0]], [[1, 0, 0]] * 2, [0, 0.5])
        np.testing.assert_allclose(skin.points, [[0, 0.01, 0]])
        np.testing.assert_allclose(skin.forces, [[0.5, 0, 0]])
        p, f = np.array([0.008, 0, 0.01]), np.array([-2.0, 0.1, 0])
        tip = palpate.contact_of_wrench(f, np.cross(p, f), a=[0, 0, 0], b=[0, 0, 0.02], radius=0.008)
        np.testing.assert_allclose(tip.points, [p], atol=1e-9)
        np.testing.assert_allclose(tip.normals, [[-1, 0, 0]], atol=1e-6)
        none = palpate.contact_of_wrench([0, 0, 0.01], [0, 0, 0], a=[0] * 3, b=[0] * 3, radius=0.01)
        self.assertEqual(len(none), 0)

    def test_normal_estimator_follows_a_plane(self):
        estimator = palpate.NormalEstimator("s2")
        random = np.random.default_rng(4)
        for tick in range(100):
            point = [0.0005 * tick, 0.0003 * tick * np.sin(0.2 * tick), 0]
            force = [0.1, 0, -1] + 0.02 * random.standard_normal(3)
            estimate = estimator.update(0.01 * tick, [point], [force])
        self.assertEqual(estimate.status, "tracked")
        self.assertGreater(estimate.normal[2], np.cos(np.radians(15)))
        with self.assertRaisesRegex(ValueError, "no_such_estimator"):
            palpate.NormalEstimator("no_such_estimator")


class Results(unittest.TestCase):
    def test_everything_shows_itself(self):
        contacts = palpate.Contacts(*box_points(3))
        self.assertEqual(repr(contacts), "Contacts(3 points, 3 with normals)")
        touch = palpate.TouchAction([0.2, 0, 0], [-1, 0, 0])
        model = palpate.ObjectModel(palpate.load_known_object("box"))
        met = palpate.predict_touch(model, np.eye(4), touch)
        for shown in (touch, met, model, model.object, model.object.mesh):
            self.assertIn(type(shown).__name__, repr(shown))
        stub = (pathlib.Path(palpate.__file__).parent / "_core.pyi").read_text()
        self.assertNotIn("std::", stub)

    def test_results_are_frozen_and_show_themselves(self):
        model = palpate.ObjectModel(palpate.load_known_object("box"))
        posterior = palpate.localize(model, palpate.Contacts(*box_points(18)))
        with self.assertRaises(AttributeError):
            posterior.status = "certain"
        with self.assertRaises(AttributeError):
            posterior.best.weight = 1.0
        self.assertIn("certain", repr(posterior))
        self.assertRegex(repr(posterior.best), r"deg, translation .* mm")
        html = posterior._repr_html_()
        self.assertGreater(html.count("<circle"), 100)
        self.assertIn("within 5 deg and 10 mm", html)

    def test_a_posterior_outlives_the_model_that_it_came_from(self):
        model = palpate.ObjectModel(palpate.load_known_object("box"))
        posterior = palpate.localize(model, palpate.Contacts(*box_points(18)))
        del model
        self.assertIn("<circle", posterior._repr_html_())

    def test_threads_run_at_the_same_time(self):
        """The GIL is free while the search runs: another thread gets on."""
        model = palpate.ObjectModel(palpate.load_known_object("box"))
        contacts = palpate.Contacts(*box_points(4))
        done, counted = threading.Event(), 0

        def search():
            palpate.localize(model, contacts, method="full")
            done.set()

        thread = threading.Thread(target=search)
        thread.start()
        while not done.is_set():
            counted += 1
        thread.join()
        self.assertGreater(counted, 1000)


if __name__ == "__main__":
    unittest.main()
