# SPDX-License-Identifier: Apache-2.0
"""pick --place and eval --place."""

import json

from cli import BAD_INPUT, STOPPED, USAGE, CliTest, main

QUICK = [
    "--set", "explore.touches=4", "--set", "explore.max_touches=4", "--set", "lift.hold=0.2",
    "--set", "estimation.search.proposals=20000", "--set", "estimation.search.particles=400",
    "--set", "place.certain=0.3", "--set", "start.stable_pose=0",
]  # fmt: skip
SUNK = "1 0 0 0.1 0 1 0 0.1 0 0 1 0.01 0 0 0 1"
AFLOAT = "1 0 0 0.1 0 1 0 0.1 0 0 1 0.5 0 0 0 1"


class BadTargets(CliTest):
    def assert_bad_place(self, place, *words, options=()):
        for command in ["pick", "eval"]:
            arguments = [command, "--object", "box", "--place", place, "--out", "new", *options]
            self.assert_refused(BAD_INPUT, arguments, *words)

    def test_no_target(self):
        self.assert_bad_place("shelf", "shelf", "fixture")
        self.assert_bad_place("1,2,3,4", "16 numbers")

    def test_an_empty_text(self):
        for command in ["pick", "eval"]:
            arguments = [command, "--object", "box", "--out", "new", "--place", ""]
            self.assert_refused(USAGE, arguments, "--place", "empty")
        self.assert_bad_place(self.write("pose.txt", ""), "pose.txt", "empty")

    def test_out_of_reach(self):
        self.assert_bad_place("0.9,0,0", "out of reach")

    def test_in_the_table_and_in_the_air(self):
        self.assert_bad_place(SUNK, "inside the table")
        self.assert_bad_place(AFLOAT, "in the air")
        name = self.write("pose.txt", SUNK)
        self.assert_bad_place(name, "inside the table")

    def test_fixture_too_small(self):
        self.assert_bad_place(
            "fixture", "too small", options=["--set", "place.fixture.tolerance=-0.001"])


    def test_a_stable_pose_that_it_does_not_have(self):
        self.assert_bad_place("stable_pose", "place.stable_pose", "99", options=["--set", "place.stable_pose=99"])

    def test_a_stable_pose_of_another_target(self):
        self.assert_bad_place("random", "place.stable_pose = 1", "random", options=["--set", "place.stable_pose=1"])

    def test_the_earlier_name_of_a_target(self):
        self.assert_bad_place("stance", "stable_pose")

    def test_strategies_and_turns_that_cannot_be(self):
        self.assert_bad_place("0.1,0,0", "place.strategy", "throw", options=["--set", "place.strategy=throw"])
        self.assert_bad_place("0.1,0,0", "place.fingers.max", "9",
                              options=["--set", "place.fingers.max=9"])  # fmt: skip


class Results(CliTest):
    def test_pick_places_and_reports(self):
        report = self.run_json(
            "pick", "--object", "box", "--place", "0.15,0.1,0.5", "--seed", "7", "--out", "run",
            *QUICK)  # fmt: skip
        self.assertEqual(report["status"], "ok")
        names = [phase["name"] for phase in report["phases"]]
        self.assertEqual(names[-3:], ["place", "withdraw", "verify"])
        aimed = [name for name in names[:-3] if name in ("plan-goal", "transport", "replan-goal", "correct")]
        self.assertEqual(aimed[:3], ["plan-goal", "transport", "replan-goal"])
        place = report["place"]
        self.assertEqual(place["status"], "placed")
        self.assertEqual(place["plan"]["status"], "ok")
        self.assertEqual(len(place["T_world_placed"]), 16)
        for key in ["final_error", "estimate_error", "release_motion"]:
            self.assertLessEqual({"rotation_deg", "translation_mm"}, place[key].keys())
        self.assertIn('"target":[', (self.folder / "run/replay.html").read_text())
        # The pose can still be estimated from the recording of the whole.
        replay = self.run_json("replay", "run/recording.h5")
        poses = [mode["T_world_object"] for mode in replay["modes"]]
        picked = [mode["T_world_object"] for mode in report["estimate"]["modes"]]
        self.assertEqual(poses, picked)
        self.check_fault(report["phases"], names)

    def check_fault(self, phases, names):
        """In the transport: the phases are reported, and no pose."""
        transport = names.index("transport")
        start = sum(phase["robot_seconds"] for phase in phases[:transport])
        done = self.run_program(
            "pick", "--object", "box", "--place", "0.15,0.1,0.5", "--seed", "7", "--out", "fault",
            "--no-belief", "--json", "--set", "expert.fault.kind=load_nan",
            "--set", f"expert.fault.from={start + 0.5}", *QUICK)  # fmt: skip
        self.assertEqual(done.returncode, STOPPED, done.stderr)
        report = json.loads(done.stdout)
        self.assertEqual(report["status"], "fault")
        self.assertEqual([fault["stopped"] for fault in report["faults"]], [True])
        self.assertEqual(report["failed_phase"], "transport")
        self.assertEqual([phase["name"] for phase in report["phases"]], names[:transport + 1])
        self.assertEqual(report["phases"][-1]["status"], "fault")
        self.assertIsNone(report["estimate"])
        self.assertIsNone(report["place"])
        self.assertFalse(report["held"])

    def test_the_fingers_are_reported(self):
        report = self.run_json(
            "pick", "--object", "box", "--place", "0.15,0.1,0.5", "--seed", "7", "--out", "run",
            "--set", "place.strategy=fingers", "--set", "expert.place.fingers.reorient.sampling.samples=4",
            *QUICK)  # fmt: skip
        names = [phase["name"] for phase in report["phases"]]
        self.assertIn("turn", names)
        for name in names:
            self.assertNotIn(" ", name)  # pictures of phases are named after them
        strategy = report["place"]["strategy"]
        self.assertEqual(strategy["chosen"], "fingers")
        self.assertIn("asked for", strategy["reason"])
        fingers = strategy["fingers"]
        self.assertAlmostEqual(fingers["asked_deg"], 15, places=3)
        self.assertGreater(fingers["mount_turn_deg"], fingers["asked_deg"])
        self.assertIn(fingers["end"], ["reached", "out_of_time", "drift", "losing"])
        self.assertLessEqual(
            {"left", "known", "lost", "steps", "rollouts", "robot_seconds", "plan_seconds"},
            fingers.keys())

    def test_eval_counts_places_alike_for_any_number_of_threads(self):
        command = ["eval", "--object", "box", "--place", "random", "--trials", "2", "--seed", "20",
                   *QUICK]  # fmt: skip
        one = self.run_json(*command, "--threads", "1")["objects"]["box"]
        two = self.run_json(*command, "--threads", "2")["objects"]["box"]
        self.assertEqual(one, two)
        self.assertLessEqual(
            {"certain", "placed", "tight", "dropped", "in_stable_pose", "status"}, one["place"].keys())
        self.assertIn("transport", one["phases"])
        json.dumps(one)


if __name__ == "__main__":
    main()
