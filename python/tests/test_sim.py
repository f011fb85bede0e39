# SPDX-License-Identifier: Apache-2.0
"""Picks in simulation, and a hand written in Python, which drives the same pick.

Its faults are faults of the pick, and no exception of it is lost.
"""

import pathlib
import threading
import time
import tomllib
import unittest

import numpy as np
import palpate
from quick_pick import IDEAL, QUICK, sim


class Rewritten(palpate.Hand):
    """Another hand, with every reading taken apart and put together again."""

    def __init__(self, inner):
        super().__init__(inner.description)
        self.inner, self.ticks = inner, 0

    def step(self, command):
        self.ticks += 1
        r = self.inner.step(command)
        return palpate.HandReading(
            r.time, r.joints, r.torques, r.mount_xyz, r.mount_ypr, r.mount_force,
            [[palpate.TipContact(c.point, c.normal, c.force) for c in tip] for tip in r.contacts],
        )  # fmt: skip


class Failing(Rewritten):
    """Fails from its 300th tick on."""

    def __init__(self, inner, what):
        super().__init__(inner)
        self.what = what

    def step(self, command):
        reading = super().step(command)
        return self.what(reading) if self.ticks == 300 else reading


class HandTypes(unittest.TestCase):
    def test_a_reading_keeps_what_it_is_given(self):
        contact = palpate.TipContact([0.01, 0, 0], None, [0, 0, -1], point_sigma=0.002)
        reading = palpate.HandReading(1.5, [0.1, 0.2], [0.3], [1, 2, 3], [0.1, 0, 0], [0, 0, 4],
                                      [[contact], []])  # fmt: skip
        np.testing.assert_array_equal(reading.joints, [0.1, 0.2])
        np.testing.assert_array_equal(reading.mount_force, [0, 0, 4])
        self.assertEqual([len(tip) for tip in reading.contacts], [1, 0])
        np.testing.assert_array_equal(reading.contacts[0][0].normal, [0, 0, 0])
        self.assertEqual(reading.contacts[0][0].point_sigma, 0.002)

    def test_wrong_shapes_are_refused(self):
        with self.assertRaisesRegex(ValueError, r"force has shape \(2,\)"):
            palpate.TipContact([0, 0, 0], [0, 0, 1], [0, 0])
        with self.assertRaisesRegex(ValueError, r"joints has shape \(2, 2\)"):
            palpate.HandReading(0, np.eye(2), [], [0] * 3, [0] * 3, [0] * 3, [])
        with self.assertRaisesRegex(ValueError, "33 values"):
            palpate.HandCommand([0] * 33, [0] * 3, [0] * 3)


@unittest.skipUnless(sim, "built without the simulator")
class PickInSimulation(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.model = palpate.ObjectModel(palpate.load_known_object("box"))

    def world(self):
        return sim.World(self.model, seed=3, options=IDEAL)

    def pick(self, hand, **options):
        return sim.pick(self.model, hand, seed=3, options={**QUICK, **options})

    def test_a_hand_in_python_drives_the_same_pick(self):
        plain = self.pick("shadow")
        world = self.world()
        mine = Rewritten(world.hand)
        other = self.pick(mine)
        self.assertEqual(*(
            [(p.name, p.outcome, p.robot_seconds) for p in r.phases] for r in (plain, other)
        ))  # fmt: skip
        self.assertEqual(other.events, plain.events)
        self.assertEqual((other.status, other.fault), (plain.status, "none"))
        self.assertGreater(mine.ticks, 1000)
        self.assertIsNone(other.lifted)
        self.assertIsNotNone(plain.lifted)
        self.assertEqual(bool(other.posterior.best), bool(plain.posterior.best))
        if plain.posterior.best:
            np.testing.assert_array_equal(
                other.posterior.best.T_frame_object, plain.posterior.best.T_frame_object
            )
            rotation, translation = other.posterior.error(world.truth())
            self.assertAlmostEqual(np.degrees(rotation), plain.rotation_error_deg, delta=0.5)
            self.assertAlmostEqual(1e3 * translation, plain.translation_error_mm, delta=0.5)
        self.assertIn("PickResult(", repr(plain))
        self.assertIn("<td>calibrate</td>", plain._repr_html_())

    def test_an_exception_is_a_fault(self):
        error = ConnectionError("the bus <1> is gone")

        def fail(reading):
            raise error

        hand = Failing(self.world().hand, fail)
        result = self.pick(hand)
        self.assertEqual((result.status, result.fault), ("fault", "exception"))
        self.assertIn("ConnectionError: the bus <1> is gone", result.fault_detail)
        self.assertIs(result.exception, error)
        self.assertGreater(hand.ticks, 300)  # it was eased into a safe state
        self.assertIn("the bus &lt;1> is gone", result._repr_html_())

    def test_an_interrupt_stops_the_hand_and_goes_on(self):
        def interrupt(reading):
            raise KeyboardInterrupt

        hand = Failing(self.world().hand, interrupt)
        with self.assertRaises(KeyboardInterrupt):
            self.pick(hand)
        self.assertGreater(hand.ticks, 300)

    def test_a_wrong_answer_is_a_fault(self):
        result = self.pick(Failing(self.world().hand, lambda reading: None))
        self.assertEqual(result.fault, "exception")
        self.assertIn("HandReading", result.fault_detail)

    def test_a_reading_of_another_size_is_a_fault(self):
        class Shorter(Rewritten):
            def step(self, command):
                r = super().step(command)
                return palpate.HandReading(r.time, r.joints[:-1], r.torques, r.mount_xyz, r.mount_ypr,
                                           r.mount_force, r.contacts)  # fmt: skip

        result = self.pick(Shorter(self.world().hand))
        self.assertEqual(result.fault, "out_of_range")
        self.assertIn("23 joints were read, the hand has 24", result.fault_detail)

    def test_a_late_answer_is_a_fault(self):
        def late(reading):
            time.sleep(1.0)
            return reading

        result = self.pick(Failing(self.world().hand, late), **{"safety.watchdog": 0.5})
        self.assertEqual(result.fault, "silent")
        self.assertIn("0.5 s", result.fault_detail)

    def test_drives_are_stopped_at_a_fault_and_where_a_step_hangs(self):
        stopped = threading.Event()

        def hang(reading):
            self.assertTrue(stopped.wait(60))
            return reading

        def fail(reading):
            raise ConnectionError("the bus is gone")

        for what, fault in ((fail, "exception"), (hang, "silent")):
            stopped.clear()
            result = sim.pick(self.model, Failing(self.world().hand, what), seed=3,
                              options={**QUICK, "safety.watchdog": 2.0},
                              stop_drives=stopped.set)  # fmt: skip
            self.assertEqual(result.fault, fault)
            self.assertTrue(stopped.is_set())
        with self.assertRaisesRegex(ValueError, "a palpate.Hand of your own"):
            sim.pick("box", "shadow", stop_drives=stopped.set)
        with self.assertRaisesRegex(TypeError, "stop_drives is no function"):
            sim.pick(self.model, self.world().hand, stop_drives=7)

    def test_a_hand_that_is_not_finished_is_refused(self):
        class Nothing(palpate.Hand):
            pass

        class Unmade(Rewritten):
            def __init__(self):
                self.ticks = 0

        with self.assertRaisesRegex(TypeError, r"step\(command\) has to be written"):
            self.pick(Nothing(self.world().hand.description))
        with self.assertRaisesRegex(TypeError, r"super\(\).__init__\(description\)"):
            self.pick(Unmade())

    def test_a_hand_in_python_places(self):
        world = self.world()
        result = sim.pick(self.model, Rewritten(world.hand), seed=3, options=QUICK,
                          place=[0.15, 0.1, 0.5])  # fmt: skip
        self.assertEqual(result.status, "held")
        self.assertEqual((result.place.status, result.place.placed), ("placed", None))
        np.testing.assert_allclose(result.place.T_world_target[:2, 3], [0.15, 0.1])
        self.assertLess(np.linalg.norm(world.truth()[:2, 3] - [0.15, 0.1]), 0.01)
        self.assertIn("PlaceResult(placed by wrist", repr(result.place))

    def test_targets_that_cannot_be_are_refused(self):
        hand = self.world().hand
        for place, words in (
            ([1, 2], "place has 2 values, not 3"),
            ("nowhere", "'nowhere' is not a target"),
            (np.eye(3), r"place has shape \(3, 3\), not \(4, 4\)"),
            (np.eye(4), "inside the table"),
            ([5, 5, 0], "out of reach"),
            ("stable_pose", "known only in simulation"),
        ):
            with self.assertRaisesRegex(ValueError, words):
                sim.pick(self.model, hand, place=place)

    def test_the_ideal_world_is_that_of_the_configuration(self):
        file = pathlib.Path(__file__).parents[2] / "configs" / "ideal.toml"
        options = tomllib.loads(file.read_text())

        def flat(section, prefix):
            for key, value in section.items():
                if isinstance(value, dict):
                    yield from flat(value, f"{prefix}{key}.")
                else:
                    yield prefix + key, value

        self.assertEqual(sim.IDEAL, dict(flat(options, "")))

    def test_threads_take_turns_with_a_world(self):
        world = self.world()
        command = sim.waiting_command(world.hand.description)

        def step():
            for _ in range(30):
                world.hand.step(command)

        threads = [threading.Thread(target=step) for _ in range(3)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertAlmostEqual(world.hand.step(command).time, 0.91)

    def test_a_plan_keeps_clear_of_the_object(self):
        rest = self.model.object.stable_poses[0]
        T = np.eye(4)
        T[:3, :3], T[2, 3] = rest.R_table_object, rest.height
        scene = sim.CollisionScene("shadow", self.model)
        way = np.zeros((2, 30))
        way[:, 0], way[:, 2], way[:, 1] = 0.2, 0.16, (-0.35, 0.35)
        free = sim.plan(way, scene, seed=3)
        self.assertEqual((free.status, len(free.corners), free.faults), ("ok", 2, []))
        T[2, 3] += 0.1  # in the way
        scene.place(T)
        around = sim.plan(way, scene, seed=3)
        self.assertEqual((around.status, around.unreachable), ("ok", None))
        self.assertGreater(len(around.corners), 2)
        self.assertGreaterEqual(around.duration, free.duration)
        self.assertEqual(len(around.commands), len(around.samples))
        self.assertEqual(around.arrivals, [0, len(around.samples) - 1])
        np.testing.assert_allclose(around.commands[-1].mount_xyz, way[1, :3], atol=1e-9)
        again = sim.plan(way, scene, seed=3)
        np.testing.assert_array_equal(again.samples, around.samples)
        inside = sim.plan(np.vstack([way[0], [0.2, 0, 0.16] + [0] * 27]), scene)
        self.assertEqual((inside.status, inside.faults[0][0]), ("invalid", 1))
        self.assertIn("object", scene.deepest_collision([0.2, 0, 0.16] + [0] * 27)[:2])
        for wrong, words in ((way[:1], "two waypoints"), (way[:, :6], r"not \(N, 30\)")):
            with self.assertRaisesRegex(ValueError, words):
                sim.plan(wrong, scene)
        for call in (scene.deepest_collision, scene.palm_pose):
            with self.assertRaisesRegex(ValueError, "waypoint: value 2 is nan, not finite"):
                call([0, 0, np.nan] + [0] * 27)
        with self.assertRaisesRegex(ValueError, "no object"):
            sim.CollisionScene().place(T)

    def test_the_description_is_the_hand_s(self):
        hand = self.world().hand.description
        self.assertEqual((len(hand.fingers), len(hand.joints), len(hand.actuators)), (5, 24, 20))
        self.assertAlmostEqual(hand.kinematic_error, 0.002)
        self.assertEqual(len(sim.waiting_command(hand).positions), 20)
        drawn = sim.load_hand("shadow")
        self.assertEqual(drawn.kinematic_error, 0)
        moved = drawn.with_perturbed_links(0.003, seed=5)
        self.assertEqual(moved.kinematic_error, 0.003)
        shifts = [
            np.linalg.norm(a.T_parent_link[:3, 3] - b.T_parent_link[:3, 3])
            for a, b in zip(moved.links, drawn.links)
        ]
        self.assertGreater(max(shifts), 0.001)
        again = drawn.with_perturbed_links(0.003, seed=5)
        np.testing.assert_array_equal(again.links[5].T_parent_link, moved.links[5].T_parent_link)

    def test_bad_input_is_named(self):
        with self.assertRaisesRegex(ValueError, "lift.heigth"):
            sim.pick("box", options={"lift.heigth": 0.1})
        with self.assertRaisesRegex(ValueError, "no_such_hand"):
            sim.load_hand("no_such_hand")
        with self.assertRaisesRegex(ValueError, "trials must be at least 1, not 0"):
            sim.evaluate("box", trials=0)
        with self.assertRaisesRegex(ValueError, "rms must be at least 0"):
            self.world().hand.description.with_perturbed_links(-1)
        with self.assertRaisesRegex(TypeError, "hand is 7, not a name"):
            sim.pick("box", 7)
        with self.assertRaisesRegex(ValueError, "start needs a palpate.Hand of your own"):
            sim.pick("box", start=sim.waiting_command(self.world().hand.description))
        with self.assertRaisesRegex(TypeError, "object is 7, not a name"):
            sim.World(7)
        with self.assertRaisesRegex(TypeError, "options are named by strings"):
            sim.World("box", options={7: 1})
        with self.assertRaisesRegex(ValueError, "hand.xml"):
            sim.pick("box", pathlib.Path("nothing") / "hand.xml")


if __name__ == "__main__":
    unittest.main()
