# SPDX-License-Identifier: Apache-2.0
"""pick, eval and replay."""

import csv
import json

from cli import (BAD_INPUT, NO_SOLUTION, QUICK, STOPPED, USAGE, CliTest, binary_stl, box_stl,
                 main)  # fmt: skip

ESTIMATE_KEYS = {
    "object", "T_world_object", "weight", "probability", "rotation_error_deg", "translation_error_mm", "coverage",
    "modes",
}  # fmt: skip
EVAL_KEYS = {
    "trials", "lifted", "pose_ok", "pose_tight", "coverage", "mean_probability", "confident_wrong",
    "placed", "placed_of_certain", "robot_seconds", "modes_median",
    "rotation_error_deg", "translation_error_mm", "failures", "symmetry_order",
}  # fmt: skip


class Fault(CliTest):
    def test_a_fault_of_the_hand_is_named_in_the_report_and_the_exit_code(self):
        setting = ["--set", "expert.fault.kind=load_nan", "--set", "expert.fault.from=1"]
        done = self.run_program("pick", "--object", "box", *setting, "--out", "run", "--json")
        self.assertEqual(done.returncode, STOPPED)
        report = json.loads(done.stdout)
        self.assertEqual(report["status"], "fault")
        self.assertEqual(report["faults"][0]["name"], "not_finite")
        self.assertIsNone(report["estimate"])
        self.assertLess(report["peak_load"], 60)
        self.assertTrue((self.folder / "run" / "recording.h5").exists())
        replayed = self.run_program("replay", "run")
        self.assertEqual(replayed.returncode, NO_SOLUTION)
        self.assertRegex(replayed.stdout, r"^no_pose: the recording ends in phase \w+ \(.+\); nothing was held\n$")
        hint = json.loads(self.run_program("replay", "run", "--json").stdout)["hint"]
        self.assertIn(f"ends in phase {report['phases'][-1]['name']} (", hint)

    def test_a_fault_in_spite_of_which_it_goes_on_is_named_too(self):
        quick = [*QUICK[2:], "--set", "expert.fault.kind=fingers_swapped", "--set", "attempts=1"]
        done = self.run_program("pick", "--object", "box", "--seed", "3", "--no-belief", "--out", "run", *quick)
        report = json.loads((self.folder / "run" / "report.json").read_text())
        self.assertTrue(report["faults"])
        for fault in report["faults"]:
            self.assertFalse(fault["stopped"])
            self.assertIn(f"went on after {fault['time']:.2f} s in spite of {fault['name']}: {fault['detail']}\n",
                          done.stdout)  # fmt: skip


class Units(CliTest):
    def test_a_mesh_in_millimetres(self):
        self.write("mm.stl", box_stl(50, 94, 175))
        self.run_json("pick", "--object", "mm.stl", "--units", "mm", "--seed", "3", "--out", "run", *QUICK)
        for command in ("pick", "eval"):
            self.assert_refused(BAD_INPUT, [command, "--object", "mm.stl", "--out", "new"], "--units mm")
            self.assert_refused(BAD_INPUT, [command, "--object", "box", "--units", "mm", "--out", "new"],
                                "--units mm is of mesh files, and box is none")  # fmt: skip

    def test_a_candidate_in_millimetres(self):
        self.write("mm.stl", box_stl(60, 50, 80))
        done = self.run_program("pick", "--object", "box", "--true-object", "mm.stl", "--units", "mm",
                                "--out", "run", *ABORTED)  # fmt: skip
        self.assertEqual(done.returncode, STOPPED, done.stderr)

    def test_repairs_are_reported(self):
        corners = [(0.06 * (i & 1), 0.05 * (i >> 1 & 1), 0.08 * (i >> 2 & 1)) for i in range(8)]
        self.write("inverted.stl", binary_stl([
            (0, 1, 2), (1, 3, 2), (4, 6, 5), (5, 6, 7), (0, 4, 1), (1, 4, 5),
            (2, 3, 6), (3, 7, 6), (0, 2, 4), (2, 6, 4), (1, 5, 3), (3, 5, 7),
        ], corners))  # fmt: skip
        done = self.run_program("pick", "--object", "inverted.stl", "--out", "run", *ABORTED)
        self.assertIn("mesh of inverted.stl repaired: ", done.stdout)
        report = json.loads((self.folder / "run/report.json").read_text())
        self.assertTrue(report["repairs"]["inverted.stl"])


# Ends before anything is touched, for tests of what is written.
ABORTED = ["--set", "expert.fault.kind=load_nan", "--set", "expert.fault.from=0.1"]


class BadInput(CliTest):
    def assert_bad_object(self, name, *words):
        for command in ["pick", "eval"]:
            self.assert_refused(BAD_INPUT, [command, "--object", name, "--out", "new"], *words)

    def assert_bad_option(self, arguments, *words):
        for command in ["pick", "eval"]:
            self.assert_refused(BAD_INPUT, [command, *arguments, "--out", "new"], *words)

    def test_unknown_object_is_suggested(self):
        self.assert_bad_object("bracet", "'bracet'", "did you mean 'bracket'?")

    def test_missing_mesh(self):
        self.assert_bad_object("nowhere.stl", "nowhere.stl")

    def test_folder_for_a_mesh(self):
        (self.folder / "folder.stl").mkdir()
        self.assert_bad_object("folder.stl", "folder.stl")

    def test_empty_mesh(self):
        for name in ["empty.stl", "empty.obj", "empty.ply"]:
            self.assert_bad_object(self.write(name, b""), name)

    def test_truncated_mesh(self):
        self.assert_bad_object(self.write("cut.stl", box_stl(0.1, 0.1, 0.1)[:-70]), "cut.stl")

    def test_mesh_with_a_value_that_is_no_number(self):
        self.assert_bad_object(self.write("nan.stl", box_stl(float("nan"), 0.1, 0.1)), "nan.stl")

    def test_mesh_that_cannot_be_repaired(self):
        name = self.write("open.stl", binary_stl([(0, 1, 2)], [(0, 0, 0), (0.1, 0, 0), (0, 0.1, 0)]))
        self.assert_bad_object(name, name, "volume")

    def test_object_too_large_or_small_for_the_hand(self):
        for size in [0.005, 0.5]:
            name = self.write("size.stl", box_stl(size, size, size))
            self.assert_bad_object(name, f"{size} x {size} x {size} m", "10 to 400 mm")

    def test_mesh_in_millimetres_is_measured(self):
        name = self.write("mm.stl", box_stl(80, 60, 50))
        self.assert_bad_object(name, "80 x 60 x 50 m", "millimetres")

    def test_unknown_key_is_suggested(self):
        self.assert_bad_option(["--set", "lift.heigth=0.1"], "lift.heigth", "lift.height")

    def test_value_out_of_range(self):
        self.assert_bad_option(["--set", "lift.height=7"], "lift.height", "7")

    def test_unknown_source_of_contacts(self):
        self.assert_bad_option(["--set", "touch.source=skin"], "touch.source", "skin")

    def test_value_that_is_no_number(self):
        self.assert_bad_option(["--set", "lift.height=high"], "lift.height", "high")
        self.assert_bad_option(["--set", "lift.height=nan"], "lift.height", "nan")

    def test_assignment_without_value(self):
        self.assert_bad_option(["--set", "lift.height"], "lift.height")

    def test_bad_toml_has_its_line(self):
        name = self.write("bad.toml", "attempts = 2\n[lift\nheight = 0.1\n")
        self.assert_bad_option(["--config", name], "bad.toml", "2")
        name = self.write("key.toml", "attempts = 2\n\n[lift]\nheigth = 0.1\n")
        self.assert_bad_option(["--config", name], "key.toml", "lift.height")
        self.assert_bad_option(["--config", "missing.toml"], "missing.toml")

    def test_a_place_and_a_mass_that_cannot_be(self):
        for at in ["0.1", "0.1,0.2,0.3", "9,0", "here", "0.1,0,0.01,2"]:
            self.assert_bad_option(["--at", at], "--at", at)
        self.assert_bad_option(["--at", "0,0,0.02", "--set", "start.uncertainty=0.05"],
                               "--at 0,0,0.02", "start.uncertainty is set to 0.05")
        self.assert_bad_option(["--at", "0,0,0.02", "--set", "start.uncertainty=0.04"],  # the default
                               "--at 0,0,0.02", "start.uncertainty is set to 0.04")
        for command in ["pick", "eval"]:
            self.assert_refused(USAGE, [command, "--mass", "-1", "--out", "new"], "--mass")

    def test_candidates_that_cannot_be(self):
        many = ",".join(f"generated:{seed}" for seed in range(11))
        part = self.write("part.stl", box_stl(0.06, 0.05, 0.08))
        (self.folder / "other").mkdir()
        self.write("other/part.stl", box_stl(0.05, 0.04, 0.09))
        for arguments, words in [
            ([many], ["11 objects", "at most 10"]),
            (["box,mug,box"], ["box", "twice"]),
            (["box,mug", "--mass", "0.2"], ["--mass", "2 objects"]),
            (["box,mug", "--place", "random"], ["random", "one object"]),
            (["box", "--true-object", "mug", "--place", "random"], ["random", "mug is not box"]),
            ([f"{part},./{part}"], ["twice", f"the other time as {part}"]),
            (["box,mug,duck", "--size-range", "0.1"], ["15 objects", "at most 10", "5 sizes"]),
            (["box", "--size-range", "0.1", "--place", "random"], ["known size", "0.1"]),
            ([f"{part},other/part.stl@1.1"], ["sizes of one object", "both are called part"]),
        ]:
            self.assert_refused(BAD_INPUT, ["pick", "--object", *arguments, "--out", "new"], *words)

    def test_folder_that_cannot_be_made(self):
        self.write("file", "")
        for command in ["pick", "eval"]:
            self.assert_refused(
                BAD_INPUT, [command, "--object", "box", "--out", "file/below"], "file/below")

    def test_no_recording(self):
        self.assert_refused(BAD_INPUT, ["replay", "missing.h5"], "missing.h5")
        name = self.write("text.h5", "not a recording")
        self.assert_refused(BAD_INPUT, ["replay", name], "text.h5")


class Results(CliTest):
    def test_an_object_elsewhere_and_of_another_mass(self):
        done = self.run_program("pick", "--object", "box", "--seed", "4", "--mass", "0.25", "--at",
                                "0.2,-0.15,0.01", "--out", "run", "--json")  # fmt: skip
        self.assertEqual(done.returncode, 0, done.stderr)
        report = json.loads(done.stdout)
        self.assertLess(report["estimate"]["translation_error_mm"], 10)
        x, y = report["T_world_object_true"][3], report["T_world_object_true"][7]
        self.assertLess(abs(x - 0.2) + abs(y + 0.15), 0.06)
        lift = next(phase for phase in report["phases"] if phase["name"] == "lift")
        self.assertIn("of 2.45 N", lift["outcome"])
        again = self.run_program("replay", "run/recording.h5", "--json")
        replayed = json.loads(again.stdout)
        self.assertIsNone(replayed["pick_weighed"])
        mode = replayed["modes"][0]
        self.assertEqual(mode["T_world_object"], report["estimate"]["T_world_object"])

    def test_which_of_several_objects_it_is(self):
        report = self.run_json("pick", "--object", "box,mug,bracket", "--true-object", "mug",
                               "--seed", "3", "--out", "run", *QUICK)  # fmt: skip
        estimate = report["estimate"]
        self.assertEqual([each["name"] for each in estimate["objects"]], ["box", "mug", "bracket"])
        total = sum(each["probability"] for each in estimate["objects"])
        self.assertAlmostEqual(total + estimate["other_object"], 1, places=6)
        self.assertEqual(estimate["object"], "mug")
        self.assertTrue(estimate["object_ok"])
        mug = estimate["objects"][1]["probability"]
        self.assertLessEqual(estimate["probability"], mug)
        for mode in estimate["modes"]:
            self.assertLessEqual(mode["weight"], mug)
        self.assertIn("of mug alone, which was simulated; the pick weighed box,mug,bracket\n",
                      self.run_program("replay", "run").stdout)  # fmt: skip
        replayed = json.loads(self.run_program("replay", "run", "--json").stdout)
        self.assertEqual(replayed["pick_weighed"], "box,mug,bracket")

    def test_which_size_it_is(self):
        report = self.run_json("pick", "--object", "box", "--size-range", "0.05", "--true-object", "box@1.05",
                               "--seed", "3", "--out", "run", *QUICK)  # fmt: skip
        estimate = report["estimate"]
        self.assertEqual([each["name"] for each in estimate["objects"]], ["box", "box@0.95", "box@1.05"])
        self.assertTrue(estimate["object_ok"])
        self.assertAlmostEqual(estimate["size"], 1.05, delta=0.03)
        self.assertGreater(sum(mode["weight"] for mode in estimate["modes"]), 0.5)
        self.assertIn("the pick weighed box with --size-range 0.05\n",
                      self.run_program("replay", "run").stdout)  # fmt: skip

    def test_pick_reports_and_its_recording_gives_the_same_pose(self):
        report = self.run_json("pick", "--object", "box", "--seed", "7", "--out", "run", *QUICK)
        self.check_pick_report(report)
        files = sorted(path.name for path in (self.folder / "run").iterdir())
        self.assertEqual(files, ["config.toml", "recording.h5", "replay.html", "report.json"])
        self.assertEqual(json.loads((self.folder / "run/report.json").read_text()), report)
        self.assertIn("<html", (self.folder / "run/replay.html").read_text()[:1000].lower())

        replay = self.run_json("replay", "--config", "run/config.toml", "run/recording.h5")
        poses = [(mode["T_world_object"], mode["weight"]) for mode in replay["modes"]]
        picked = report["estimate"]["modes"]
        self.assertEqual(poses, [(mode["T_world_object"], mode["weight"]) for mode in picked])

        page = (self.folder / "run/replay.html").read_text()
        for source in ("prior", "touch", "grasp", "online"):
            self.assertIn(f'"source":"{source}"', page)
        for option in (["--at", "5"], ["--object", "box"], ["--hand", "shadow"]):
            self.assert_refused(BAD_INPUT, ["replay", "run/recording.h5", *option], option[0], "MCAP")

        # What was done and sensed is recorded; what is made of it is not.
        recorded = {"touch.source": "biotac", "lift.height": "0.17", "world.noise.normal": "0.3",
                    "touch.biotac_point": "0.002", "expert.estimation.identify.other": "0.2"}  # fmt: skip
        for key, value in recorded.items():
            other = ["replay", "run/recording.h5", "--set", f"{key}={value}"]
            self.assert_refused(BAD_INPUT, other, key, "was recorded with", "options replay")
        other = self.run_json("replay", "run", "--set", "estimation.free_space=false")
        self.assertNotEqual(other["modes"], replay["modes"])

        sensed = self.run_json("sense", "run/recording.h5", "--out", "sensed")["streams"]
        self.assertNotIn("sensed/contacts.csv", self.contents())  # the object moves
        self.assertGreaterEqual(len(sensed), 2)
        for name, stream in sensed.items():
            # At an edge, links off by 2 mm turn the truth by some 15 degrees on a tip of 7 mm.
            self.assertLess(stream["error_deg"]["median"], 30, name)
        no_channels = ["sense", "run/recording.h5", "--model", "some.model"]
        self.assert_refused(BAD_INPUT, no_channels, "some.model")

        # The configuration that was written makes the same pick again.
        again = self.run_json(
            "pick", "--object", "box", "--seed", "7", "--out", "again", "--config",
            "run/config.toml")  # fmt: skip
        self.assertEqual(again["estimate"]["modes"], picked)

    def test_a_pick_by_channels_and_its_recording_give_the_same_pose(self):
        by_channels = ["--set", "touch.source=biotac"]
        report = self.run_json("pick", "--object", "box", "--seed", "7", "--out", "run", *QUICK,
                               *by_channels)  # fmt: skip
        self.check_pick_report(report)
        for settings in [], by_channels:
            replay = self.run_json("replay", "run/recording.h5", *settings)
            poses = [(mode["T_world_object"], mode["weight"]) for mode in replay["modes"]]
            picked = report["estimate"]["modes"]
            self.assertEqual(poses, [(mode["T_world_object"], mode["weight"]) for mode in picked])
        other = ["replay", "run/recording.h5", "--set", "touch.source=solver"]
        self.assert_refused(BAD_INPUT, other, "touch.source", "biotac")

    def test_a_grasp_that_fails_is_reported(self):
        slippery = ["--set", "world.hand_friction=0.01", "--set", "attempts=1"]
        done = self.run_program("pick", "--object", "box", "--seed", "3", "--out", "run", "--json",
                                *QUICK, *slippery)  # fmt: skip
        self.assertEqual(done.returncode, NO_SOLUTION, done.stderr)
        self.assertEqual(done.stderr, "")
        report = json.loads(done.stdout)
        self.assertEqual(report["status"], "failed")
        self.assertIn(report["failed_phase"], [phase["name"] for phase in report["phases"]])
        self.assertFalse(report["lifted"])
        files = sorted(path.name for path in (self.folder / "run").iterdir())
        self.assertEqual(files, ["config.toml", "recording.h5", "replay.html", "report.json"])
        self.run_json("view", "run/recording.h5", "--out", "pages")

    def test_a_lost_object_has_no_pose(self):
        """This bottle slips out of the hand in the lift, after its pose was estimated."""
        done = self.run_program("pick", "--object", "bottle", "--seed", "15136", "--json",
                                "--quiet", "--out", "run", "--set", "attempts=1")  # fmt: skip
        self.assertEqual(done.returncode, NO_SOLUTION, done.stderr)
        report = json.loads(done.stdout)
        self.assertEqual(report["failed_phase"], "lift")
        outcomes = {phase["outcome"].split(":")[0].split(" ")[0] for phase in report["phases"]}
        self.assertTrue({"certain", "ambiguous"} & outcomes, outcomes)
        self.assertFalse(report["held"])
        self.assertFalse(report["lifted"])
        self.assertIsNone(report["estimate"])

    def assert_not_tried(self, report, reason):
        self.assertEqual((report["status"], report["failed_phase"]), ("failed", "refuse"))
        self.assertEqual([phase["name"] for phase in report["phases"]], ["refuse"])
        self.assertIn(reason, report["phases"][0]["outcome"])
        self.assertEqual(report["attempts"], 0)

    def test_what_the_hand_cannot_hold_is_not_tried(self):
        self.write("cube.stl", box_stl(0.15, 0.15, 0.15))
        for options, reason in [(["--object", "cube.stl", "--mass", "0.4"], "too wide: 150 mm"),
                                (["--object", "box", "--mass", "3.2"], "too heavy: it weighs 31.4 N"),
                                (["--object", "box", "--mass", "5"], "the mount may bear 36 N")]:  # fmt: skip
            with self.subTest(reason):
                done = self.run_program("pick", *options, "--out", "run", "--force", "--json")
                self.assertEqual(done.returncode, NO_SOLUTION, done.stderr)
                self.assert_not_tried(json.loads(done.stdout), reason)
        done = self.run_program("pick", "--object", "box", "--mass", "5", "--out", "again")
        self.assertIn("refused: too heavy", done.stdout)

    def check_pick_report(self, report):
        self.assertEqual(report["status"], "ok")
        self.assertEqual((report["object"], report["seed"]), ("box", 7))
        self.assertIsNone(report["failed_phase"])
        for key in ["lifted", "placed"]:
            self.assertIsInstance(report[key], bool)
        self.assertGreaterEqual(report["attempts"], 1)
        self.assertLessEqual(ESTIMATE_KEYS, report["estimate"].keys())
        self.assertEqual(len(report["estimate"]["T_world_object"]), 16)
        self.assertEqual(report["estimate"]["T_world_object"][12:], [0, 0, 0, 1])
        for mode in report["estimate"]["modes"]:
            self.assertLessEqual({"T_world_object", "weight", "free_axis"}, mode.keys())
        names = [phase["name"] for phase in report["phases"]]
        self.assertEqual(names[:2], ["calibrate", "height_probe"])
        self.assertIn("pose", names)
        self.assertIn(names[-1], ("pose", "touch_table", "probe"))
        for phase in report["phases"]:
            keys = {"name", "status", "robot_seconds", "wall_seconds", "contacts"}
            self.assertLessEqual(keys, phase.keys())

    def test_eval_is_the_same_for_any_number_of_threads(self):
        command = ["eval", "--object", "box", "--trials", "2", "--seed", "20",
                   "--set", "attempts=1", *QUICK]  # fmt: skip
        one = self.run_json(*command, "--threads", "1")
        two = self.run_json(*command, "--threads", "2", "--out", "runs")
        self.assertEqual(one["objects"], two["objects"])
        self.check_trials("box", [20, 21], one["objects"]["box"])
        self.assertEqual(one["objects"]["box"]["trials"], 2)
        self.assertLessEqual(EVAL_KEYS, one["objects"]["box"].keys())
        of_all = {key: one["objects"]["box"][key] for key in one["all"]}
        self.assertEqual(one["all"], of_all)

    def check_trials(self, name, seeds, report):
        """runs/trials.csv has a row for each trial, from which the report's rates follow."""
        with open(self.folder / "runs" / "trials.csv", newline="") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual([(row["object"], int(row["seed"])) for row in rows],
                         [(name, seed) for seed in seeds])  # fmt: skip
        for row in rows:
            self.assertIn(row["pose_status"], ["certain", "ambiguous", "no_pose"])
            self.assertLessEqual(float(row["probability"]), float(row["weight"] or 0) + 1e-4)
            self.assertGreaterEqual(float(row["free_axis_deg"]), 0)
        for key in ["lifted", "pose_ok", "pose_tight"]:
            share = sum(int(row[key]) for row in rows) / len(rows)
            self.assertEqual(share, report[key], key)
        lifted = [row for row in rows if int(row["lifted"])]
        covered = sum(int(row["covered"]) for row in lifted)
        self.assertEqual(covered / len(lifted) if lifted else None, report["coverage"])
        self.assertIsNone(report["placed_of_certain"])  # nothing was to be placed
        self.assertEqual(report["repairs"], [])


if __name__ == "__main__":
    main()
