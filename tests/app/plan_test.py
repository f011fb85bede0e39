# SPDX-License-Identifier: Apache-2.0
"""The plan command: paths through waypoints, and every kind of waypoint that cannot be."""

import csv
import json

from cli import BAD_INPUT, DONE, NO_SOLUTION, USAGE, CliTest, box_stl, main

FINGERS = {"FF": "4321", "MF": "4321", "RF": "4321", "LF": "54321"}
JOINTS = ["WRJ2", "WRJ1", *(f"THJ{i}" for i in "54321")]
JOINTS += [f"{finger}J{i}" for finger, numbers in FINGERS.items() for i in numbers]
BASE = ["x", "y", "z", "yaw", "pitch", "roll"]
UPRIGHT = "1 0 0 0  0 1 0 0  0 0 1 0  0 0 0 1"


class Plan(CliTest):
    def waypoints(self, *rows, columns=tuple(JOINTS), name="q.csv"):
        """A file of rows, each given as {column: value}; all else is 0."""
        lines = [",".join(columns)]
        lines += [",".join(str(row.get(column, 0)) for column in columns) for row in rows]
        return self.write(name, "\n".join(lines) + "\n")

    def reach(self, *places, **options):
        rows = [dict(zip("xyz", place)) for place in places]
        return self.waypoints(*rows, columns=BASE + JOINTS, **options)

    def test_a_configuration_is_not_overwritten_unasked(self):
        file = self.waypoints({}, {"FFJ3": 0.8}, {})
        (self.folder / "mine").mkdir()
        self.write("mine/config.toml", "kept")
        self.assert_refused(BAD_INPUT, ["plan", file, "--quiet", "--out", "mine"], "mine/config.toml", "--force")
        self.assertEqual((self.folder / "mine/config.toml").read_text(), "kept")

    def test_fingers_move_and_the_hand_follows(self):
        file = self.waypoints({}, {"FFJ3": 0.8, "FFJ2": 0.5}, {})
        report = self.run_json("plan", file, "--execute", "--out", "out")
        self.assertEqual((report["status"], report["invalid"]), ("ok", []))
        self.assertAlmostEqual(report["duration"], (report["samples"] - 1) * 0.01, delta=1e-9)
        self.assertEqual(len(report["arrivals"]), 3)
        self.assertEqual(report["arrivals"][-1], report["samples"] - 1)
        tracking = report["tracking"]
        self.assertLess(0, tracking["joint_rms"])
        self.assertLessEqual(tracking["joint_rms"], tracking["joint_max"])
        with open(self.folder / "out" / "path.csv") as text:
            rows = list(csv.DictReader(text))
        self.assertEqual(len(rows), report["samples"])
        self.assertEqual(list(rows[0]), ["t_s", *BASE, *JOINTS])
        middle = rows[report["arrivals"][1]]
        self.assertAlmostEqual(float(middle["FFJ3"]), 0.8, delta=1e-9)
        self.assertAlmostEqual(float(middle["FFJ1"]) + float(middle["FFJ2"]), 0.5, delta=1e-9)
        self.assertTrue((self.folder / "out" / "path.svg").read_text().startswith("<svg"))
        self.assertEqual(json.loads((self.folder / "out" / "report.json").read_text()), report)

    def test_the_next_command_is_named(self):
        file = self.waypoints({}, {"FFJ3": 0.8, "FFJ2": 0.5}, {})
        for options, more in (([], "--execute lets"), (["--execute"], "--out out/plan writes")):
            line = self.run_program("plan", file, *options).stdout.splitlines()[-1]
            self.assertTrue(line.startswith(" ".join(["Next: palpate plan", file, *options, more])), line)

    def test_goes_around_the_box(self):
        self.write("box.stl", box_stl(0.2, 0.04, 0.16))
        file = self.reach((0.1, -0.25, 0.12), (0.1, 0.3, 0.12))
        arguments = ["plan", file, "--object", "box.stl", "--pose", UPRIGHT, "--seed", "3"]
        blocked = self.run_json(*arguments, "--out", "around")
        self.assertGreater(blocked["corners"], 2)
        self.run_json(*arguments, "--out", "again")
        paths = [(self.folder / run / "path.csv").read_text() for run in ("around", "again")]
        self.assertEqual(*paths)
        free = self.run_json("plan", file)
        self.assertEqual(free["corners"], 2)
        stuck = self.run_program(*arguments, "--json", "--set", "detour=0", "--set", "iterations=50")
        self.assertEqual(stuck.returncode, NO_SOLUTION, stuck.stderr)
        report = json.loads(stuck.stdout)
        self.assertEqual((report["status"], report["unreachable"]), ("no_path", 1))

    def test_invalid_waypoints_are_listed(self):
        file = self.waypoints({}, {"FFJ3": 2.5}, {"MFJ1": 0.5})
        self.assert_refused(BAD_INPUT, ["plan", file], "waypoint 1", "FFJ3 = 2.5", "waypoint 2")
        done = self.run_program("plan", file, "--json")
        self.assertEqual(done.returncode, BAD_INPUT)
        report = json.loads(done.stdout)
        self.assertEqual(report["status"], "invalid")
        self.assertEqual([fault["waypoint"] for fault in report["invalid"]], [1, 2])
        self.assertIn("FFJ3", report["invalid"][0]["reason"])

    def test_collisions_name_the_pair(self):
        low = self.reach((0, 0, 0.3), (0, 0, -0.05), name="low.csv")
        self.assert_refused(BAD_INPUT, ["plan", low], "waypoint 1", "z = -0.05")
        table = self.reach((0, 0, 0.3), (0, 0, 0.0), name="table.csv")
        self.assert_refused(BAD_INPUT, ["plan", table], "waypoint 1", "table")
        crossed = self.waypoints({}, {"FFJ4": 0.349})
        self.assert_refused(BAD_INPUT, ["plan", crossed], "waypoint 1", "ff", "mf")

    def test_held_object_meets_the_table(self):
        self.write("box.stl", box_stl(0.2, 0.04, 0.16))
        file = self.reach((0, 0, 0.4), (0.1, 0, 0.15))
        pose = "1 0 0 -.1  0 1 0 -.02  0 0 1 .2  0 0 0 1"
        held = ["plan", file, "--object", "box.stl", "--pose", pose, "--held"]
        self.assert_refused(BAD_INPUT, held, "waypoint 1", "object", "table")
        self.run_json("plan", file)

    def test_waypoints_that_differ_by_rounding(self):
        file = self.waypoints({"FFJ2": 0.3}, {"FFJ2": 0.2, "FFJ1": 0.1})  # 0.1 + 0.2 is not 0.3
        report = self.run_json("plan", file)
        self.assertEqual((report["status"], report["arrivals"]), ("ok", [0, 0]))

    def test_the_hand_of_the_options_is_planned_for(self):
        file = self.waypoints({}, {"FFJ3": 0.5})
        options = ["--set", "world.hand=nosuch"]
        self.assert_refused(BAD_INPUT, ["plan", file, *options], "nosuch")

    def test_an_object_in_the_air_is_not_simulated_on_the_table(self):
        """The hand is where the box would stand, which is above it."""
        self.write("box.stl", box_stl(0.1, 0.1, 0.2))
        file = self.reach((0, 0, 0.15), (0.01, 0, 0.15))
        tracking = {}
        for height in (0.6, 0.9):
            pose = f"1 0 0 -.05  0 1 0 -.05  0 0 1 {height}  0 0 0 1"
            report = self.run_json("plan", file, "--object", "box.stl", "--pose", pose, "--execute")
            tracking[height] = report["tracking"]
        free = self.run_json("plan", file, "--execute")["tracking"]
        self.assertLess(tracking[0.6]["joint_max"], 2 * free["joint_max"] + 0.01)
        self.assertLess(tracking[0.6]["mount_max"], 2 * free["mount_max"] + 0.002)
        self.assertEqual(tracking[0.6], tracking[0.9])

    def test_files_that_are_no_waypoints(self):
        good = ",".join(JOINTS) + "\n" + ",".join("0" * 24) + "\n"
        for text, *words in [
            ("", "q.csv is empty"),
            (good, "not 1"),
            (good + "0,0\n", "q.csv:3", "2 values"),
            (good + ",".join(["nan"] + ["0"] * 23) + "\n", "q.csv:3", "nan", "WRJ2"),
            ("a,b\n0,0\n", "2 columns"),
        ]:
            self.assert_refused(BAD_INPUT, ["plan", self.write("q.csv", text)], *words)
        self.assert_refused(BAD_INPUT, ["plan", "none.csv"], "none.csv")

    def test_usage(self):
        file = self.waypoints({}, {"FFJ3": 0.5})
        self.assert_refused(USAGE, ["plan", file, "--planner", "a-star"], "a-star")
        self.assert_refused(BAD_INPUT, ["plan", file, "--held"], "--object")
        self.assert_refused(BAD_INPUT, ["plan", file, "--pose", UPRIGHT], "--object")
        self.assert_refused(
            BAD_INPUT, ["plan", file, "--object", "box", "--pose", "1 2 3"], "16 numbers"
        )
        self.assertEqual(self.run_program("plan", "--help").returncode, DONE)


if __name__ == "__main__":
    main()
