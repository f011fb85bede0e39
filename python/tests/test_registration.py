# SPDX-License-Identifier: Apache-2.0
"""Registration of pairs and clouds in numpy's terms."""

import tempfile
import unittest

import numpy as np
import palpate


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
        start = self.truth.copy()
        start[0, 3] += 0.01
        near = palpate.register_described(points, points, moved, points, voxel=0.01, initial=start,
                                          primitive="point")
        np.testing.assert_allclose(near.result.T_target_source, self.truth, atol=1e-6)
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
    """Of the duck, whose poses are measured by how far they put its points from its surface."""

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

    def test_arrays_are_read_where_they_lie(self):
        found = palpate.register_clouds(self.source, self.target)
        wide = np.full((len(self.source), 7), np.nan)
        wide[:, 2:5] = self.source.points
        for source in (self.source.points, wide[:, 2:5], self.source.points.tolist(),
                       np.asfortranarray(self.source.points), self.source.points.astype(">f8")):
            again = palpate.register_clouds(source, self.target.points)
            np.testing.assert_array_equal(again.result.T_target_source,
                                          found.result.T_target_source)
        single = palpate.register_clouds(wide[:, 2:5].astype(np.float32), self.target)
        at = [0.3, 0.2, -0.1]
        self.assertLess(self.gaps(single.result.T_target_source, 1, self.source, at).mean(), 0.001)
        backward = palpate.register_clouds(wide[::-1, 2:5], self.target)
        self.assertLess(self.gaps(backward.result.T_target_source, 1, self.source, at).mean(), 0.001)

    def test_arrays_that_are_no_clouds_are_refused(self):
        with self.assertRaisesRegex(ValueError, r"target has shape \(5, 2\), not \(N, 3\)"):
            palpate.register_clouds(self.source, np.zeros((5, 2)))
        with self.assertRaisesRegex(ValueError, "source: complex128 is no real number"):
            palpate.register_clouds(np.zeros((5, 3), complex), self.target)
        with self.assertRaisesRegex(ValueError, "source: could not convert"):
            palpate.register_clouds([["a", "b", "c"]], self.target)
        with self.assertRaisesRegex(ValueError, "point 2 is not finite"):
            palpate.register_clouds(np.array([[0, 0, 0], [1, 0, 0], [0, 0, np.inf]]), self.target)
        self.assertEqual(palpate.register_clouds([], self.target).result.status, "degenerate")

    def test_bound(self):
        found = palpate.register_clouds(self.source, self.target, bound_nodes=1000)
        bound = found.result.certificate.robust_bound
        self.assertGreaterEqual(bound.max_inliers, found.feature_inliers)
        self.assertGreaterEqual(bound.cost, bound.min_cost)
        self.assertGreater(bound.min_cost, 0)

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


if __name__ == "__main__":
    unittest.main()
