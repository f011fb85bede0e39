# SPDX-License-Identifier: Apache-2.0
"""An arm and sensors written in Python: the same pick drives them, and their faults name them."""

import math
import time
import unittest

import numpy as np
import palpate
from quick_pick import IDEAL, QUICK, sim
from test_arms import six_axes


class Lift(palpate.Arm):
    """Carries the simulated hand: the fingers below ask it where they are."""

    def __init__(self):
        unlimited = math.inf
        super().__init__("lift", acceleration=unlimited, turn_acceleration=unlimited,
                         guarded_speed=unlimited)  # fmt: skip
        self.target = self.reading = None
        self.reads = 0

    def move(self, target):
        self.target = target

    def read(self):
        self.reads += 1
        return self.reading


class Fingers(palpate.Hand):
    """The simulated hand, which says nothing of its mount and of its first finger's contacts."""

    def __init__(self, inner, arm, tip):
        super().__init__(inner.description)
        self.inner, self.arm, self.tip, self.ticks = inner, arm, tip, 0

    def step(self, command):
        self.ticks += 1
        place = self.arm.target
        r = self.inner.step(palpate.HandCommand(command.positions, place.xyz, place.ypr))
        self.arm.reading = palpate.ArmReading(
            palpate.MountPosition(r.mount_xyz, r.mount_ypr), r.mount_force
        )
        self.tip.sensed = r.contacts[0]
        return palpate.HandReading(r.time, r.joints, r.torques, [0] * 3, [0] * 3, [0] * 3,
                                   [[], *r.contacts[1:]])  # fmt: skip


class Tip(palpate.Sensor):
    def __init__(self, finger):
        super().__init__(finger)
        self.sensed, self.reads = [], 0

    def read(self):
        self.reads += 1
        return self.sensed


class JointArm(palpate.Arm):
    """An arm that takes joint angles: its driver does at once what it is commanded."""

    def __init__(self, arm, hand):
        super().__init__(arm.name)
        self.arm, self.follower = arm, palpate.ArmFollower(arm)
        start = sim.waiting_command(hand)
        self.commanded = [self.follower.reset(start.T_world_mount, palpate.working_tour(hand))]
        self.force = np.zeros(3)

    def move(self, target):
        self.target = target
        self.commanded.append(self.follower.follow(target.T_world_mount))

    def where(self):
        """Of the hand's mount, by the joints."""
        return palpate.MountPosition.at(self.arm.mount_pose(self.commanded[-1]), near=self.target)

    def read(self):
        return palpate.ArmReading(self.where(), self.force)

    def check_path(self, way):
        return self.follower.check_path(way)


class CarriedFingers(palpate.Hand):
    """The simulated hand, which is where the arm's joints bring it."""

    def __init__(self, inner, arm):
        super().__init__(inner.description)
        self.inner, self.arm = inner, arm

    def step(self, command):
        place = self.arm.where()
        r = self.inner.step(palpate.HandCommand(command.positions, place.xyz, place.ypr))
        self.arm.force = r.mount_force
        return palpate.HandReading(r.time, r.joints, r.torques, [0] * 3, [0] * 3, [0] * 3,
                                   r.contacts)  # fmt: skip


class PartTypes(unittest.TestCase):
    def test_positions_and_poses(self):
        position = palpate.MountPosition([0.1, 0.2, 0.3], [0.5, 0.1, -0.2])
        again = palpate.MountPosition.at(position.T_world_mount)
        np.testing.assert_allclose(again.xyz, [0.1, 0.2, 0.3])
        np.testing.assert_allclose(again.ypr, [0.5, 0.1, -0.2])
        reading = palpate.ArmReading(position, [0, 0, 2])
        np.testing.assert_array_equal(reading.mount.xyz, [0.1, 0.2, 0.3])
        np.testing.assert_array_equal(reading.mount_force, [0, 0, 2])
        with self.assertRaisesRegex(ValueError, r"mount_force has shape \(2,\)"):
            palpate.ArmReading(position, [0, 0])
        with self.assertRaisesRegex(ValueError, "T_world_mount"):
            palpate.MountPosition.at(np.ones((4, 4)))

    def test_angles_may_be_the_nearest(self):
        turned = palpate.MountPosition([0, 0, 0.1], [3.3, 0.2, 0])
        principal = palpate.MountPosition.at(turned.T_world_mount)
        self.assertLess(principal.ypr[0], 0)
        again = palpate.MountPosition.at(turned.T_world_mount, near=turned)
        np.testing.assert_allclose(again.ypr, turned.ypr, atol=1e-12)

    def test_limits_are_positive(self):
        with self.assertRaisesRegex(ValueError, "guarded_speed is 0"):
            palpate.Arm("lift", guarded_speed=0)
        self.assertEqual(palpate.Arm("lift").name, "lift")
        self.assertEqual(palpate.Sensor("thumb").finger, "thumb")

    def test_what_is_to_be_written_says_so(self):
        with self.assertRaisesRegex(NotImplementedError, r"move\(target\)"):
            palpate.Arm("lift").move(palpate.MountPosition([0] * 3, [0] * 3))
        with self.assertRaisesRegex(NotImplementedError, r"read\(\)"):
            palpate.Sensor("thumb").read()
        self.assertEqual(palpate.Arm("lift").check_path([]), "")


@unittest.skipUnless(sim, "built without the simulator")
class PickWithParts(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.model = palpate.ObjectModel(palpate.load_known_object("box"))

    def setUp(self):
        self.world = sim.World(self.model, seed=3, options=IDEAL)
        self.first = self.world.hand.description.fingers[0].name
        self.use(Lift(), Tip(self.first))

    def use(self, arm, tip):
        self.arm, self.tip = arm, tip
        self.fingers = Fingers(self.world.hand, arm, tip)

    def pick(self, **options):
        return sim.pick(self.model, self.fingers, arm=self.arm, sensors=[self.tip], seed=3,
                        options={**QUICK, **options})  # fmt: skip

    def from_read(self, call, part):
        """Replaces what a part reads by call(), from its 300th reading on."""

        def read():
            answer = type(part).read(part)
            return call() if part.reads >= 300 else answer

        part.read = read

    def test_parts_in_python_drive_the_same_pick(self):
        plain = sim.pick(self.model, "shadow", seed=3, options=QUICK)
        other = self.pick()
        self.assertEqual(*(
            [(p.name, p.outcome, p.robot_seconds) for p in r.phases] for r in (plain, other)
        ))  # fmt: skip
        self.assertEqual(other.events, plain.events)
        self.assertEqual((other.status, other.fault), (plain.status, "none"))
        self.assertEqual(bool(other.posterior.best), bool(plain.posterior.best))
        if plain.posterior.best:
            np.testing.assert_array_equal(
                other.posterior.best.T_frame_object, plain.posterior.best.T_frame_object
            )
        self.assertEqual((self.arm.reads, self.tip.reads), (self.fingers.ticks,) * 2)

    def test_an_exception_is_a_fault_with_the_part_s_name(self):
        error = ConnectionError("the bus is gone")

        def fail():
            raise error

        for which, name in (("arm", "the arm 'lift'"), ("tip", f"the sensor '{self.first}'")):
            self.setUp()
            self.from_read(fail, getattr(self, which))
            result = self.pick()
            self.assertEqual((result.status, result.fault), ("fault", "exception"))
            self.assertIn(f"{name}: ConnectionError: the bus is gone", result.fault_detail)
            self.assertIs(result.exception, error)
            self.assertGreater(self.fingers.ticks, 310)  # what remains was eased

    def test_an_interrupt_in_a_part_goes_on(self):
        def interrupt():
            raise KeyboardInterrupt

        self.from_read(interrupt, self.tip)
        with self.assertRaises(KeyboardInterrupt):
            self.pick()

    def test_another_answer_is_a_fault_with_the_part_s_name(self):
        self.from_read(lambda: 7, self.arm)
        result = self.pick()
        self.assertEqual(result.fault, "exception")
        self.assertIn("the arm 'lift': read() returned 7, not an ArmReading", result.fault_detail)
        self.setUp()
        self.from_read(lambda: "hard", self.tip)
        self.assertIn("read() returned 'hard', not Contacts", self.pick().fault_detail)

    def test_a_late_answer_is_a_fault_with_the_part_s_name(self):
        def late():
            time.sleep(1.0)
            return self.arm.reading

        self.from_read(late, self.arm)
        result = self.pick(**{"safety.watchdog": 0.5})
        self.assertEqual(result.fault, "silent")
        self.assertRegex(result.fault_detail, r"the arm 'lift' took \d.* at most 0.5 s")

    def test_a_part_that_says_nothing_more_is_named(self):
        self.from_read(lambda: None, self.tip)
        result = self.pick()
        self.assertEqual(result.fault, "silent")
        self.assertEqual(
            result.fault_detail, f"the sensor '{self.first}': no new reading for 0.25 s"
        )

    def test_a_hand_that_stands_elsewhere_is_not_commanded(self):
        fingers, outer = self.fingers, self

        class Sensing(Fingers):
            def sense(self):
                d = self.description
                joints, torques = np.full(len(d.joints), 0.01), np.full(len(d.actuators), 0.01)
                outer.arm.reading = palpate.ArmReading(
                    palpate.MountPosition([0.4, 0, 0.34], [0] * 3), [0] * 3
                )
                return palpate.HandReading(0, joints, torques, [0] * 3, [0] * 3, [0] * 3,
                                           [[] for _ in d.fingers])  # fmt: skip

        self.fingers = Sensing(fingers.inner, self.arm, self.tip)
        result = self.pick()
        self.assertEqual(result.fault, "not_at_start", result.fault_detail)
        self.assertIsNone(self.arm.target)
        self.assertEqual(self.fingers.ticks, 0)
        self.fingers.sense = lambda: 7
        result = self.pick()
        self.assertEqual(result.fault, "exception")
        self.assertIn("sense() returned something else", result.fault_detail)

    def test_a_way_that_the_arm_cannot_go_is_not_begun(self):
        self.arm.check_path = lambda way: "the ceiling is in the way" if len(way) > 5 else ""
        result = self.pick()
        self.assertEqual((result.status, result.fault), ("failed", "none"))
        self.assertIn("unreachable: the ceiling is in the way", result.phases[-1].outcome)

    def test_an_arm_in_joint_space_lifts_the_box(self):
        description = self.world.hand.description
        arm = JointArm(six_axes(), description)
        fingers = CarriedFingers(self.world.hand, arm)
        result = sim.pick(self.model, fingers, arm=arm, seed=3, options=QUICK)
        self.assertEqual(result.fault, "none", result.fault_detail)
        speeds = np.abs(np.diff(arm.commanded, axis=0)) / 0.01
        self.assertGreater(len(arm.commanded), 1000)
        self.assertLessEqual(speeds.max(), 2 + 1e-9)
        self.assertEqual(result.status, "held", result)
        self.assertLess(result.posterior.error(self.world.truth())[1], 0.01)

    def test_arms_of_a_file(self):
        description = self.world.hand.description
        with self.assertRaisesRegex(ValueError, "'crane' is neither an arm"):
            sim.load_arm("crane", description)
        with self.assertRaisesRegex(ValueError, "'floating' is no arm"):
            sim.load_arm("floating", description)
        with self.assertRaisesRegex(ValueError, "adapter"):
            sim.load_arm("crane", description, adapter=7)

    def test_an_exception_in_judging_is_a_fault(self):
        def fail(way):
            raise LookupError("no map")

        self.arm.check_path = fail
        result = self.pick()
        self.assertEqual(result.fault, "exception")
        self.assertIn("the arm 'lift': LookupError: no map", result.fault_detail)

    def test_a_sensor_may_answer_contacts(self):
        """As the adapters of sensors give them; forces and errors reach the pick."""

        class Gel(Tip):
            def read(self):
                super().read()
                contacts = [c for c in self.sensed if np.any(c.normal)]
                return palpate.Contacts(
                    np.reshape([c.point for c in contacts], (-1, 3)),
                    np.reshape([c.normal for c in contacts], (-1, 3)),
                    np.reshape([c.force for c in contacts], (-1, 3)),
                )

        self.use(Lift(), Gel(self.first))
        result = self.pick()
        self.assertEqual(result.fault, "none", result.fault_detail)
        self.assertGreater(self.tip.reads, 1000)

    def test_bad_parts_are_refused(self):
        with self.assertRaisesRegex(ValueError, "no finger is called 'toe'.*the hand has"):
            sim.pick("box", self.fingers, sensors=[palpate.Sensor("toe")])
        with self.assertRaisesRegex(ValueError, "need a palpate.Hand of your own, not 'shadow'"):
            sim.pick("box", "shadow", arm=self.arm)
        with self.assertRaises(TypeError):
            sim.pick("box", self.fingers, arm=7)


if __name__ == "__main__":
    unittest.main()
