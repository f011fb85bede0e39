# SPDX-License-Identifier: Apache-2.0
"""Models, contacts and results go to other processes and come back as they were."""

import copy
import multiprocessing
import pickle
import unittest

import numpy as np
import palpate
from box_contacts import box_points

try:
    from palpate import sim
except ImportError:
    sim = None

STATEFUL = {"Arm", "ArmFollower", "Hand", "HeldPoseFollower", "NormalEstimator", "Sensor", "Tracker"}
DESCRIPTIONS = {"Actuator", "ArmDescription", "ArmJoint", "ArmReading", "BasePosition", "Finger",
                "HandJoint", "HandLink", "PathFeasibility"}  # fmt: skip


def localized(model, contacts, seed):
    return palpate.localize(model, contacts, seed=seed)


class Pickles(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.model = palpate.ObjectModel(palpate.load_known_object("box"))
        cls.contacts = palpate.Contacts(*box_points(5))
        cls.posterior = palpate.localize(cls.model, cls.contacts)

    def same(self, a, b, where):
        """All that is public of two values; times, too."""
        self.assertIs(type(a), type(b), where)
        if isinstance(a, np.ndarray):
            np.testing.assert_array_equal(a, b, where)
            self.assertEqual(a.dtype, b.dtype, where)
        elif isinstance(a, (list, tuple)):
            self.assertEqual(len(a), len(b), where)
            for i, (x, y) in enumerate(zip(a, b)):
                self.same(x, y, f"{where}[{i}]")
        elif type(a).__module__.startswith("palpate"):
            self.assertEqual(repr(a), repr(b), where)
            names = [name for name, member in vars(type(a)).items()
                     if not name.startswith("_") and isinstance(member, property)]  # fmt: skip
            self.assertTrue(names or hasattr(a, "__len__") or "Support" in where, where)
            for name in names:
                self.same(getattr(a, name), getattr(b, name), f"{where}.{name}")
        else:
            self.assertEqual(a, b, where)

    def comes_back(self, value):
        for other in (pickle.loads(pickle.dumps(value)), copy.deepcopy(value)):
            self.same(value, other, type(value).__name__)
        return other

    def test_objects_and_results(self):
        random = np.random.default_rng(3)
        points = random.standard_normal((30, 3))
        clouds = [palpate.PointCloud(palpate.load_known_object("bracket").mesh.vertices)] * 2
        pairs = palpate.register_correspondences(points, points + [1, 2, 3], bound_nodes=100)
        touch = palpate.TouchAction([0.2, 0, 0], [-1, 0, 0])
        estimator = palpate.NormalEstimator("s2")
        contact = palpate.TipContact([0.01, 0, 0], None, [0, 0, -1], point_sigma=0.002)
        values = [
            self.model, self.model.object, self.model.object.mesh,
            self.model.object.stable_poses[0], self.contacts, self.contacts.candidates(),
            self.posterior, self.posterior.best, palpate.prior_from(self.posterior),
            palpate.TableSupport(np.eye(4)), pairs, pairs.certificate,
            pairs.certificate.robust_bound, palpate.register_clouds(*clouds, instances=2), clouds[0],
            palpate.certify(np.eye(4), points, points), touch,
            palpate.predict_touch(self.model, np.eye(4), touch),
            estimator.update(0.0, points[:2], points[2:4]), contact,
            self.model.object.mesh.closest_points(points),
            palpate.HandReading(1, [0.1, 0.2], [0.3], [1, 2, 3], [0.1, 0, 0], [0, 0, 4],
                                [[contact], []]),
            palpate.HandCommand([0.1, 0.2], [1, 2, 3], [0, 0, 1]),
        ]  # fmt: skip
        for value in values:
            self.comes_back(value)

    def test_free_axes_and_free_motions(self):
        one = palpate.localize(
            palpate.ObjectModel(palpate.load_known_object("bottle")),
            palpate.Contacts([[0.03, 0, 0.02], [0.0, 0.03, 0.02]], [[1, 0, 0], [0, 1, 0]]),
        )
        axes = [mode.free_axis for mode in one.modes if mode.free_axis]
        self.assertTrue(axes)
        self.comes_back(axes[0])
        line = np.outer(np.arange(8.0), [1, 0, 0])
        free = palpate.register_correspondences(line, line).free_motions
        self.assertTrue(free)
        self.comes_back(free[0])

    def test_a_model_that_came_back_finds_the_same(self):
        other = pickle.loads(pickle.dumps(self.model))
        found = palpate.localize(other, self.contacts)
        self.assertEqual(len(found.modes), len(self.posterior.modes))
        for a, b in zip(found.modes, self.posterior.modes):
            np.testing.assert_array_equal(a.T_frame_object, b.T_frame_object)
            self.assertEqual(a.weight, b.weight)
        self.assertEqual(pickle.loads(pickle.dumps(self.posterior))._repr_html_(),
                         self.posterior._repr_html_())  # fmt: skip

    def test_a_model_is_kept_once_for_many_results(self):
        mug = palpate.ObjectModel(palpate.load_known_object("mug"))
        one, other = (palpate.localize(mug, self.contacts, seed=seed) for seed in (0, 1))
        both, each, model = (sum(len(pickle.dumps(value)) for value in values)
                             for values in ([[one, other]], [one, other], [mug]))  # fmt: skip
        self.assertLess(both, each - 0.9 * model)

    def test_a_pool_of_processes(self):
        with multiprocessing.get_context("spawn").Pool(1) as pool:
            (found,) = pool.starmap(localized, [(self.model, self.contacts, 0)])
        np.testing.assert_array_equal(found.best.T_frame_object, self.posterior.best.T_frame_object)

    def test_every_class_is_decided_about(self):
        """What has a state of its own, or belongs to a robot, says that it cannot be pickled."""
        for name in palpate.__all__:
            value = getattr(palpate, name)
            if not isinstance(value, type):
                continue
            self.assertEqual("__setstate__" not in vars(value), name in STATEFUL | DESCRIPTIONS, name)
        with self.assertRaisesRegex(TypeError, "NormalEstimator"):
            pickle.dumps(palpate.NormalEstimator())

    def test_a_state_that_is_none_is_refused(self):
        empty = palpate.Mode.__new__(palpate.Mode)
        with self.assertRaisesRegex(ValueError, "1 values, not 2"):
            empty.__setstate__((1,))
        mesh = palpate.Mesh.__new__(palpate.Mesh)
        with self.assertRaisesRegex(ValueError, "names vertices 0, 1, 7 of 3"):
            mesh.__setstate__((np.eye(3), [[0, 1, 7]]))

    @unittest.skipUnless(sim, "built without the simulator")
    def test_picks_and_plans(self):
        quick = sim.IDEAL | {"calibrate.touches": 2, "explore.touches": 0, "explore.max_touches": 0,
                 "attempts": 1, "estimation.search.proposals": 8000}  # fmt: skip
        result = sim.pick(self.model, seed=3, options=quick, place=[0.15, 0.1, 0.5])
        other = self.comes_back(result)
        self.assertEqual(other.lifted, result.lifted)
        self.comes_back(sim.evaluate(self.model, trials=1, seed=3, options=quick))
        rows = np.zeros((2, 30))
        rows[:, 2], rows[1, 0] = 0.3, 0.1
        self.comes_back(sim.plan(rows, sim.CollisionScene()))


if __name__ == "__main__":
    unittest.main()
