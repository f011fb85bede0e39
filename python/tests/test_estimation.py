# SPDX-License-Identifier: Apache-2.0
"""Which object it is, and the pose of what a hand holds, from its readings alone."""

import copy
import pickle
import unittest

import numpy as np
import palpate

try:
    from palpate import sim
except ImportError:
    sim = None


def touched(name, count, noise=0.001):
    """Contacts with an object at the identity, by a fixed seed."""
    random = np.random.default_rng(5)
    model = palpate.ObjectModel(palpate.load_known_object(name))
    mesh = model.object.mesh
    corners = mesh.vertices[mesh.triangles]
    sides = corners[:, 1:] - corners[:, :1]
    areas = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    chosen = corners[random.choice(len(corners), count, p=areas / areas.sum())]
    points = np.einsum("ij,ijk->ik", random.dirichlet([1, 1, 1], count), chosen)
    normals = mesh.closest_points(points).normals
    points += noise * random.standard_normal((count, 3))
    return model, palpate.Contacts(points, normals, point_sigma=0.001)


class Identification(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.mug, cls.contacts = touched("mug", 24)
        cls.box, cls.bracket = (
            palpate.ObjectModel(palpate.load_known_object(name)) for name in ("box", "bracket")
        )
        cls.found = palpate.identify([cls.box, cls.mug, cls.bracket], cls.contacts, seed=2)

    def test_the_object_that_was_touched_is_found_with_its_pose(self):
        self.assertEqual(self.found.best, 1)
        self.assertGreater(self.found.probabilities[1], 0.9)
        self.assertAlmostEqual(sum(self.found.probabilities) + self.found.other, 1)
        rotation, translation = self.found.posterior.error(np.eye(4))
        self.assertLess(np.degrees(rotation), 5)
        self.assertLess(translation, 0.01)
        self.assertRegex(repr(self.found), r"Identification\('mug', probability (1\.0|0\.9)")

    def test_weights_are_of_pose_and_object(self):
        for posterior, probability in zip(self.found.posteriors, self.found.probabilities):
            total = sum(mode.weight for mode in posterior.modes)
            self.assertLessEqual(total, probability + 1e-9)

    def test_without_the_right_object_it_is_none_of_them(self):
        found = palpate.identify([self.box, self.bracket], self.contacts, seed=2)
        self.assertIsNone(found.best)
        self.assertEqual(found.posterior.modes, [])
        self.assertIn("no pose of any object", repr(found))

    def test_it_is_pickled_and_draws_itself(self):
        again = pickle.loads(pickle.dumps(self.found))
        self.assertEqual(again.probabilities, self.found.probabilities)
        np.testing.assert_array_equal(
            again.posterior.best.T_frame_object, self.found.posterior.best.T_frame_object
        )
        self.assertIn("<td>mug</td>", self.found._repr_html_())

    def test_what_cannot_be_used_is_refused(self):
        for error, text, call in (
            (ValueError, "models: 0 objects", lambda: palpate.identify([], self.contacts)),
            (TypeError, "not an ObjectModel", lambda: palpate.identify(["box"], self.contacts)),
            (ValueError, "other must be", lambda: palpate.identify([self.box], self.contacts, other=1)),
            (ValueError, "free sphere 0",
             lambda: palpate.identify([self.box], self.contacts, free_space=[[0, 0, 0, -1]])),
        ):  # fmt: skip
            with self.assertRaisesRegex(error, text):
                call()


@unittest.skipUnless(sim, "built without the simulator")
class HeldPose(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.world = sim.World("box", seed=1, options=sim.IDEAL)
        command = cls.world.grasp(1)
        cls.readings = [cls.world.hand.step(command) for _ in range(30)]
        cls.hand = cls.world.hand.description
        cls.model = palpate.ObjectModel(palpate.load_known_object("box"))

    def follower(self, **options):
        return palpate.HeldPoseFollower(self.model, self.hand, **options)

    def off(self, posterior):
        rotation, translation = posterior.error(self.world.truth())
        return np.degrees(rotation), 1e3 * translation

    def near_truth(self):
        """What contacts of a known place say: the true pose to within a degree."""
        contacts = touched("box", 18, 0)[1].transformed(self.world.truth())
        return palpate.localize(self.model, contacts, seed=1)

    def test_a_known_pose_is_kept_by_what_the_fingers_sense(self):
        follower = self.follower(seed=4)
        self.assertEqual(follower.posterior.status, "no_pose")
        self.assertFalse(follower.due)
        follower.update(self.readings[0])
        follower.begin(self.near_truth())
        for reading in self.readings[1:]:
            follower.update(reading)
            if follower.due:
                follower.estimate()
        degrees, millimetres = self.off(follower.posterior)
        self.assertLess(degrees, 10)
        self.assertLess(millimetres, 10)

    def test_the_same_seed_gives_the_same_estimate(self):
        poses = []
        for _ in range(2):
            follower = self.follower(seed=9)
            for reading in self.readings:
                follower.update(reading)
            poses.append(follower.estimate().best.T_frame_object)
        np.testing.assert_array_equal(*poses)

    def test_what_is_let_go_is_forgotten(self):
        follower = self.follower(lost_after=0.1)
        follower.update(self.readings[0])
        follower.begin(self.near_truth())
        last = self.readings[-1]
        for tick in range(1, 30):
            follower.update(
                palpate.HandReading(last.time + 0.01 * tick, last.joints, last.torques, last.mount_xyz,
                                    last.mount_ypr, last.mount_force, [[]] * len(last.contacts))
            )  # fmt: skip
        self.assertEqual(follower.posterior.modes, [])

    def test_what_cannot_be_used_is_refused(self):
        last = self.readings[0]

        def reading(**changed):
            parts = {name: getattr(last, name) for name in
                     ("time", "joints", "torques", "mount_xyz", "mount_ypr", "mount_force", "contacts")}  # fmt: skip
            return palpate.HandReading(**{**parts, **changed})

        follower = self.follower()
        mug, contacts = touched("mug", 12)
        for text, call in (
            ("update.. comes first", follower.estimate),
            ("comes first", lambda: follower.begin(self.near_truth())),
            ("3 joints in the reading", lambda: follower.update(reading(joints=[0] * 3))),
            ("0 fingers in the reading", lambda: follower.update(reading(contacts=[]))),
            ("is not finite", lambda: follower.update(reading(mount_xyz=[np.nan, 0, 0]))),
            ("is not finite", lambda: follower.update(reading(time=np.nan))),
            ("posterior is of 'mug', not 'box'",
             lambda: follower.begin(palpate.localize(mug, contacts))),
            ("period must be within", lambda: self.follower(period=0)),
            ("fingers must be within", lambda: self.follower(fingers=100)),
        ):  # fmt: skip
            with self.assertRaisesRegex(ValueError, text):
                call()
        follower.update(last)
        with self.assertRaisesRegex(ValueError, "is not later than"):
            follower.update(last)

    def test_a_description_is_pickled(self):
        for other in (pickle.loads(pickle.dumps(self.hand)), copy.deepcopy(self.hand)):
            self.assertEqual(repr(other), repr(self.hand))
            self.assertEqual([link.name for link in other.links], [k.name for k in self.hand.links])
            follower = palpate.HeldPoseFollower(self.model, other, seed=9)
            mine = self.follower(seed=9)
            for reading in self.readings:
                follower.update(reading)
                mine.update(reading)
            np.testing.assert_array_equal(
                follower.estimate().best.T_frame_object, mine.estimate().best.T_frame_object
            )


if __name__ == "__main__":
    unittest.main()
