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
DESCRIPTIONS = {"Actuator", "ArmDescription", "ArmJoint", "ArmReading", "MountPosition", "Finger",
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

    def some_of_each_class(self):
        random = np.random.default_rng(3)
        points = random.standard_normal((30, 3))
        clouds = [palpate.PointCloud(palpate.load_known_object("bracket").mesh.vertices)] * 2
        pairs = palpate.register_correspondences(points, points + [1, 2, 3], bound_nodes=100)
        touch = palpate.TouchAction([0.2, 0, 0], [-1, 0, 0])
        estimator = palpate.NormalEstimator("s2")
        contact = palpate.TipContact([0.01, 0, 0], None, [0, 0, -1], point_sigma=0.002)
        return [
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

    def test_objects_and_results(self):
        for value in self.some_of_each_class():
            self.comes_back(value)

    def is_frozen(self, value, where):
        """What is written into an array that a property returns does not reach the value."""
        if isinstance(value, (list, tuple)):
            for i, one in enumerate(value):
                self.is_frozen(one, f"{where}[{i}]")
        if not type(value).__module__.startswith("palpate"):
            return
        for name, member in vars(type(value)).items():
            if name.startswith("_") or not isinstance(member, property):
                continue
            found = getattr(value, name)
            if isinstance(found, np.ndarray):
                before = found.copy()
                if found.flags.writeable:
                    found[...] = 17
                np.testing.assert_array_equal(getattr(value, name), before, f"{where}.{name}")
            else:
                self.is_frozen(found, f"{where}.{name}")

    def test_results_are_frozen(self):
        place = palpate.MountPosition([1, 2, 3], [0.1, 0.2, 0.3])
        values = [*self.some_of_each_class(), *self.free_motions(), *self.free_axes(), place,
                  palpate.ArmReading(place, [1, 2, 3])]  # fmt: skip
        for value in values:
            self.is_frozen(value, type(value).__name__)

    def free_axes(self):
        one = palpate.localize(
            palpate.ObjectModel(palpate.load_known_object("bottle")),
            palpate.Contacts([[0.03, 0, 0.02], [0.0, 0.03, 0.02]], [[1, 0, 0], [0, 1, 0]]),
        )
        axes = [mode.free_axis for mode in one.modes if mode.free_axis]
        self.assertTrue(axes)
        return axes

    def free_motions(self):
        line = np.outer(np.arange(8.0), [1, 0, 0])
        free = palpate.register_correspondences(line, line).free_motions
        self.assertTrue(free)
        return free

    def test_free_axes_and_free_motions(self):
        self.comes_back(self.free_axes()[0])
        self.comes_back(self.free_motions()[0])

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

    def damaged(self, value, state, words):
        with self.assertRaisesRegex(ValueError, words):
            type(value).__new__(type(value)).__setstate__(state)

    def test_damaged_contacts_are_refused(self):
        state = self.contacts.__getstate__()
        for index, part in enumerate(state):
            other = [*state]
            other[index] = part[:2]
            self.damaged(self.contacts, tuple(other), "points holds .* values of each")
            if index < 5:
                part = part.copy()
                part.flat[-1] = np.nan
                other[index] = part
                self.damaged(self.contacts, tuple(other), "contact 4: .*(not finite|not positive)")
        for index in (3, 4):
            other = [*state]
            other[index] = 0 * state[index]
            self.damaged(self.contacts, tuple(other), "contact 0: .*_sigma is 0, not positive")

    def replaced(self, state, path, part):
        """A state, which is of tuples and lists, with another part there."""
        if not path:
            return part
        parts = list(state)
        parts[path[0]] = self.replaced(parts[path[0]], path[1:], part)
        return type(state)(parts)

    def test_damaged_states_are_refused(self):
        axis = self.free_axes()[0]
        touch = palpate.TouchAction([0.2, 0, 0], [-1, 0, 0])
        found = palpate.identify([self.model], self.contacts)
        scaled = 2 * np.eye(4)
        for value, path, part, words in (
            (axis, [2], 1e12, "free axis of .* rad"),
            (axis, [2], np.nan, "free axis of .* nan rad"),
            (self.posterior.best, [0, 0], scaled, "state: a pose is not a rigid motion"),
            (self.posterior.best, [0, 0], np.eye(3), r"state has shape \(3, 3\), not \(4, 4\)"),
            (self.posterior.best, [0, 1], np.nan, "a mode of weight nan"),
            (self.posterior.best, [0, 1], "heavy", "value of another type"),
            (self.posterior.best, [], 7, "value of another type"),
            (self.model, [1, 0], 1e3 * self.model.object.mesh.vertices, "'box' is 175 m long"),
            (self.model.object, [1, 1], [], "0 triangles"),
            (self.model.object.mesh, [], "mesh", "value of another type"),
            (touch, [0], [np.inf, 0, 0], "value of another type|start is not finite"),
            (touch, [2], -1.0, "reach is -1"),
            (found, [0, 2], 7, "object 7 of 1"),
            (found, [0, 0], [], "with 0 probabilities"),
        ):  # fmt: skip
            self.damaged(value, self.replaced(value.__getstate__(), path, part), words)

    @unittest.skipUnless(sim, "built without the simulator")
    def test_a_damaged_hand_is_refused(self):
        for name in ("shadow", "allegro"):
            hand = sim.load_hand(name)
            self.comes_back(hand)
        state = hand.__getstate__()
        link, actuator, finger, sphere = (state[i][0] for i in (1, 4, 5, 7))
        for path, part, words in (
            ([1, 0, 1], 0, "parent of a link of a hand is 0"),
            ([1, len(state[1]) - 1, 4], 99, "joint of a link of a hand is 99"),
            ([2], 1000, "palm of a hand is 1000"),
            ([3], [], "a hand of 0 joints"),
            ([4, 0, 3], 9, "finger of an actuator of a hand is 9"),
            ([4, 0, 1, 0, 0], -1, "joint of an actuator of a hand is -1"),
            ([5, 0, 1], -1, "link of a fingertip of a hand is -1"),
            ([5], 9 * [finger], "a hand of 9 fingers"),
            ([6], 8, "thumb of a hand is 8"),
            ([7, 0, 0], 1000, "link of a sphere of a hand is 1000"),
            ([8, 2], np.zeros(3), "a posture of 3 values"),
            ([8, 5, 3], [], "0 attitudes"),
        ):  # fmt: skip
            self.damaged(hand, self.replaced(state, path, part), words)

    @unittest.skipUnless(sim, "built without the simulator")
    def test_picks_and_plans(self):
        quick = sim.IDEAL | {"calibrate.touches": 2, "explore.touches": 0, "explore.max_touches": 0,
                 "attempts": 1, "estimation.search.proposals": 8000}  # fmt: skip
        result = sim.pick(self.model, seed=3, options=quick, place=[0.15, 0.1, 0.5])
        other = self.comes_back(result)
        self.assertEqual(other.lifted, result.lifted)
        self.is_frozen(result, "PickResult")
        for path, words in (([3, 0], "a fault of number 99"), ([5, 0, 0], "an event of number 99")):
            state, posterior = result.__getstate__()
            self.damaged(result, (self.replaced(state, path, 99), posterior), words)
        self.comes_back(sim.evaluate(self.model, trials=1, seed=3, options=quick))
        rows = np.zeros((2, 30))
        rows[:, 2], rows[1, 0] = 0.3, 0.1
        plan = self.comes_back(sim.plan(rows, sim.CollisionScene()))
        self.is_frozen(plan, "Plan")
        for width in (5, 100):
            state = self.replaced(plan.__getstate__(), [3], np.zeros((2, width)))
            self.damaged(plan, state, f"samples of {width} values, not 6 to 38")


if __name__ == "__main__":
    unittest.main()
