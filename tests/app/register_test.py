# SPDX-License-Identifier: Apache-2.0
"""The register and certify commands: correspondences, clouds of all formats, and bad input."""

import json
import math
import random

from cli import BAD_INPUT, NO_SOLUTION, USAGE, CliTest, box_stl, main

QUARTER_TURN = [0, -1, 0, 0.1, 1, 0, 0, 0.2, 0, 0, 1, 0.3, 0, 0, 0, 1]  # about z, and a shift
IDENTITY = "1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1"
MIRROR = "1,0,0,0,0,1,0,0,0,0,-1,0,0,0,0,1"


def moved(p):
    return (-p[1] + 0.1, p[0] + 0.2, p[2] + 0.3)


def lump(seed, count=2500):
    """Points of a closed surface without symmetry, some 0.1 m large."""
    source = random.Random(seed)
    points = []
    for _ in range(count):
        z, a = source.uniform(-1, 1), source.uniform(0, 2 * math.pi)
        s = math.sqrt(1 - z * z)
        x, y = s * math.cos(a), s * math.sin(a)
        r = 1 + 0.25 * math.sin(3 * x + 1) * math.cos(4 * y) + 0.2 * math.sin(5 * z + 2 * x)
        points.append((0.05 * r * x, 0.04 * r * y, 0.03 * r * z))
    return points


def xyz(points):
    return "".join("{} {} {}\n".format(*p) for p in points)


def pcd(points):
    return (
        "VERSION .7\nFIELDS x y z\nSIZE 8 8 8\nTYPE F F F\nCOUNT 1 1 1\n"
        f"WIDTH {len(points)}\nHEIGHT 1\nPOINTS {len(points)}\nDATA ascii\n" + xyz(points)
    )


def ply(points):
    return (
        f"ply\nformat ascii 1.0\nelement vertex {len(points)}\nproperty double x\n"
        "property double y\nproperty double z\nend_header\n" + xyz(points)
    )


class Register(CliTest):
    def pairs(self, count=60, wrong=30):
        source = random.Random(7)
        rows = ["sx,sy,sz,tx,ty,tz"]
        for k in range(count):
            p = [source.uniform(-0.05, 0.05) for _ in range(3)]
            q = moved([source.uniform(-0.05, 0.05) for _ in range(3)]) if k < wrong else moved(p)
            rows.append(",".join(f"{v:.6f}" for v in (*p, *q)))
        return self.write("pairs.csv", "\n".join(rows) + "\n")

    def assert_quarter_turn(self, pose, delta):
        for found, expected in zip(pose, QUARTER_TURN):
            self.assertAlmostEqual(found, expected, delta=delta)

    def test_correspondences(self):
        file = self.pairs()
        for method in (["--method", "gnc"], ["--method", "gnc", "--cost", "gm"], []):
            report = self.run_json("register", "--correspondences", file, *method)
            self.assertEqual(report["status"], "found")
            self.assertEqual(report["inliers"], list(range(30, 60)))
            self.assertEqual(len(report["covariance"]), 6)
            self.assertLess(report["false_alarms"], 1e-6)
            self.assertTrue(report["certificate"]["least_squares"])
            self.assertGreaterEqual(report["certificate"]["robust_bound"]["max_inliers"], 30)
            self.assertIsNone(report["runner_up"])
            self.assert_quarter_turn(report["T_target_source"], 1e-4)

    def test_gnc_leaves_out_pairs_of_weight_0(self):
        self.pairs()
        rows = (self.folder / "pairs.csv").read_text().splitlines()
        weighted = [row + f",{float(k % 2 == 0 or k >= 50)}" for k, row in enumerate(rows[1:])]
        file = self.write("weighted.csv", "\n".join([rows[0] + ",weight", *weighted]) + "\n")
        report = self.run_json("register", "--correspondences", file, "--method", "gnc")
        self.assertEqual(report["inliers"], [k for k in range(30, 60) if k % 2 == 0 or k >= 50])

    def test_out_holds_what_was_done(self):
        file = self.pairs()
        self.run_json("register", "--correspondences", file, "--method", "gnc", "--out", "out")
        report = json.loads((self.folder / "out/report.json").read_text())
        history = (self.folder / "out/weights.csv").read_text().splitlines()
        self.assertEqual(len(history), 1 + report["iterations"])
        again = self.run_json("register", "--correspondences", "out/correspondences.csv")
        self.assertEqual(again["inliers"], report["inliers"])

    def test_certify(self):
        file = self.pairs(wrong=0)
        pose = ",".join(map(str, QUARTER_TURN))
        self.assertEqual(
            self.run_json("certify", pose, "--correspondences", file)["status"], "certified"
        )
        self.run_json("certify", pose, "--correspondences", file, "--out", "proof")
        report = json.loads((self.folder / "proof/report.json").read_text())
        self.assertEqual(report["status"], "certified")
        wrong = self.run_program(
            "certify", IDENTITY, "--correspondences", file
        )
        self.assertEqual(wrong.returncode, NO_SOLUTION)

    def test_why_a_pose_is_not_certified(self):
        command = ["certify", IDENTITY, "--correspondences", self.pairs(wrong=0)]
        done = self.run_program(*command, "--noise-bound", "0.004")
        self.assertEqual(done.returncode, NO_SOLUTION)
        self.assertIn("of 0 correspondences\n", done.stdout)
        self.assertIn("no pair is within 0.004 m of this pose; nothing to certify\n", done.stdout)
        done = self.run_program(*command)
        self.assertIn("all 60 pairs count; if there are outliers among them, use --noise-bound\n", done.stdout)
        self.assertIn("above the global optimum", done.stdout)
        self.assertIn("\nNext: palpate register --correspondences pairs.csv ", done.stdout)
        self.assertNotIn("Next:", self.run_program(*command, "--quiet").stdout)

    def test_what_a_person_reads_of_a_pose(self):
        """Of a cloud on itself: no rounding errors, no 0 expected; of one in mm: the hint first."""
        clouds = [self.write("a.xyz", xyz(lump(2))), self.write("b.xyz", xyz(lump(2)))]
        text = self.run_program("register", *clouds, "--yaw-only").stdout
        self.assertIn("rotation (0.000, 0.000, 0.000) deg, translation (0, 0, 0) m", text)
        self.assertNotIn(" 0 such poses", text)
        self.assertIn("\nNext: palpate register a.xyz b.xyz --yaw-only --out out/register writes", text)
        self.write("mm.xyz", xyz([[1000 * c for c in p] for p in lump(2)]))
        lines = self.run_program("register", "a.xyz", "mm.xyz").stdout.splitlines()
        self.assertIn("is one of them in millimetres?", lines[0])
        self.assertIn("correspondences are inliers", lines[1])

    def test_clouds_of_all_formats(self):
        target = self.write("target.xyz", xyz([moved(p) for p in lump(1)]))
        for name, text in (("s.xyz", xyz(lump(2))), ("s.pcd", pcd(lump(2))), ("s.ply", ply(lump(2)))):
            report = self.run_json("register", self.write(name, text), target)
            self.assertEqual(report["status"], "found")
            self.assertGreater(report["overlap"], 0.5)  # of two samplings, points rarely coincide
            self.assertGreater(report["feature_matches"], 20)
            bound = report["certificate"]["robust_bound"]["max_inliers"]
            self.assertLessEqual(report["feature_inliers"], bound)
            self.assertLessEqual(bound, report["feature_matches"])
            self.assertGreater(report["feature_inliers"], 10)
            self.assert_quarter_turn(report["T_target_source"], 0.05)

    def test_clouds_of_known_scale_and_gravity(self):
        small = [[1000 * c for c in p] for p in lump(2)]
        clouds = [self.write("mm.xyz", xyz(small)),
                  self.write("t.xyz", xyz([moved(p) for p in lump(1)]))]
        for limit in ([], ["--yaw-only"], ["--gravity", "0", "0", "-9.81"]):
            report = self.run_json("register", *clouds, "--known-scale", "0.001", *limit)
            self.assertEqual((report["status"], report["scale"]), ("found", 0.001))
            self.assert_quarter_turn(report["T_target_source"], 0.05)
            if limit:
                self.assertAlmostEqual(report["T_target_source"][10], 1, delta=1e-12)
                self.assertEqual(report["covariance"][0], [0.0] * 6)

    def test_clouds_of_unknown_scale_and_several_instances(self):
        target = [moved(p) for p in lump(1)]
        clouds = [self.write("mm.xyz", xyz([[1000 * c for c in p] for p in lump(2)])),
                  self.write("t.xyz", xyz(target))]
        report = self.run_json("register", *clouds, "--scale")
        self.assertEqual(report["status"], "found")
        self.assertAlmostEqual(report["scale"], 0.001, delta=1e-5)
        self.assert_quarter_turn(report["T_target_source"], 0.05)
        self.run_json("register", *clouds, "--scale", "--out", "scaled")
        placed = self.run_json("register", "scaled/source_in_target.ply", clouds[1])
        for found, expected in zip(placed["T_target_source"], map(float, IDENTITY.split(","))):
            self.assertAlmostEqual(found, expected, delta=0.01)
        both = target + [(p[0] + 0.4, p[1], p[2]) for p in lump(3)]
        clouds = [self.write("s.xyz", xyz(lump(2))), self.write("both.xyz", xyz(both))]
        report = self.run_json("register", *clouds, "--instances", "3")
        self.assertEqual(len(report["instances"]), 1)
        shifts = sorted(pose["T_target_source"][3] for pose in (report, *report["instances"]))
        self.assertAlmostEqual(shifts[1], 0.4, delta=0.005)

    def test_several_instances_and_the_runner_up(self):
        source = random.Random(9)
        rows = ["sx,sy,sz,tx,ty,tz"]
        for k in range(100):
            p = [source.uniform(-0.05, 0.05) for _ in range(3)]
            q = moved(p) if k < 60 else (p[0] + 0.4, p[1], p[2])
            rows.append(",".join(f"{v:.6f}" for v in (*p, *q)))
        file = self.write("two.csv", "\n".join(rows) + "\n")
        report = self.run_json("register", "--correspondences", file, "--instances", "3")
        self.assertEqual(report["inliers"], list(range(60)))
        self.assertEqual([one["inliers"] for one in report["instances"]], [40])
        self.assertAlmostEqual(report["runner_up"]["T_target_source"][3], 0.4, delta=1e-4)

    def test_scale_yaw_and_initial(self):
        source = random.Random(8)
        rows = ["sx,sy,sz,tx,ty,tz,weight"]
        for k in range(60):
            p = [source.uniform(-0.05, 0.05) for _ in range(3)]
            rows.append(",".join(f"{v:.6f}" for v in (*p, *moved([2 * c for c in p]), 1 + k)))
        file = self.write("scaled.csv", "\n".join(rows) + "\n")
        report = self.run_json("register", "--correspondences", file, "--scale")
        self.assertAlmostEqual(report["scale"], 2, delta=1e-3)
        self.assert_quarter_turn(report["T_target_source"], 1e-3)
        file = self.pairs()
        report = self.run_json("register", "--correspondences", file, "--yaw-only")
        self.assert_quarter_turn(report["T_target_source"], 1e-4)
        near = list(QUARTER_TURN)
        near[3] += 0.002
        start = self.write("near.txt", " ".join(map(str, near)))
        report = self.run_json("register", "--correspondences", file, "--initial", start)
        self.assert_quarter_turn(report["T_target_source"], 1e-4)

    def test_translation_only_and_clouds_from_an_initial_pose(self):
        source = random.Random(6)
        rows = ["sx,sy,sz,tx,ty,tz"]
        for _ in range(40):
            p = [source.uniform(-0.05, 0.05) for _ in range(3)]
            rows.append(",".join(f"{v:.6f}" for v in (*p, p[0] + 0.1, p[1], p[2])))
        file = self.write("shifted.csv", "\n".join(rows) + "\n")
        report = self.run_json("register", "--correspondences", file, "--translation-only")
        shifted = [1, 0, 0, 0.1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
        for found, expected in zip(report["T_target_source"], shifted):
            self.assertAlmostEqual(found, expected, delta=1e-5)
        clouds = [self.write("s.xyz", xyz(lump(2))),
                  self.write("t.xyz", xyz([moved(p) for p in lump(1)]))]
        near = list(QUARTER_TURN)
        near[3] += 0.003
        start = self.write("near.txt", " ".join(map(str, near)))
        report = self.run_json("register", *clouds, "--initial", start)
        self.assertEqual(report["feature_matches"], 0)
        self.assertEqual(report["false_alarms"], 1)
        self.assert_quarter_turn(report["T_target_source"], 0.02)
        text = self.run_program("register", *clouds, "--initial", start).stdout
        self.assertNotIn("false alarms", text)

    def test_a_ball_is_degenerate(self):
        source = random.Random(3)
        points = []
        for _ in range(3000):
            z, a = source.uniform(-1, 1), source.uniform(0, 2 * math.pi)
            s = math.sqrt(1 - z * z)
            points.append((0.05 * s * math.cos(a), 0.05 * s * math.sin(a), 0.05 * z))
        ball = self.write("ball.xyz", xyz(points))
        done = self.run_program("register", ball, ball, "--json")
        self.assertEqual(done.returncode, NO_SOLUTION)
        report = json.loads(done.stdout)
        self.assertEqual(report["status"], "degenerate")
        self.assertIsNone(report["T_target_source"])
        self.assertEqual([m["kind"] for m in report["free_motions"]], ["rotation"] * 3)

    def test_too_few_points_are_said(self):
        few = self.write("few.xyz", "1 2 3\n4 5 6\n")
        done = self.run_program("register", few, self.write("lump.xyz", xyz(lump(1))), "--json")
        self.assertEqual(done.returncode, NO_SOLUTION)
        report = json.loads(done.stdout)
        self.assertEqual(report["status"], "degenerate")
        self.assertIn("the source has 2 and the target 2500 points", report["hint"])

    def test_outliers_alone_are_no_consensus(self):
        file = self.pairs(wrong=60)
        done = self.run_program("register", "--correspondences", file, "--json", "--out", "none")
        self.assertEqual(done.returncode, NO_SOLUTION)
        # Without a pose there are no residuals; the file can be read all the same.
        again = self.run_program("register", "--correspondences", "none/correspondences.csv")
        self.assertEqual(again.returncode, NO_SOLUTION)
        report = json.loads(done.stdout)
        self.assertEqual(report["status"], "no_consensus")
        self.assertIsNone(report["T_target_source"])

    def test_clouds_and_pairs_that_may_be_in_millimetres(self):
        points = lump(3, 400)
        large = [[1000 * c for c in p] for p in points]
        row = lambda p, q: ",".join(f"{c:.6f}" for c in (*p, *q))
        header = "sx,sy,sz,tx,ty,tz\n"
        for name, sources, targets, question in (
            ("half.csv", large, points, "is one of them in millimetres?"),
            ("both.csv", large, [moved(p) for p in large], ""),
            ("noisy.csv", large, list(reversed(large)), "are they in millimetres?"),
        ):
            self.write(name, header + "\n".join(map(row, sources, targets)) + "\n")
            done = self.run_program("register", "--correspondences", name, "--json")
            self.assertIn(question, json.loads(done.stdout)["hint"], name)
            self.assertEqual(done.returncode == NO_SOLUTION, question != "", name)
        done = self.run_program("certify", IDENTITY, "--correspondences", "half.csv", "--json",
                                "--noise-bound", "0.004")  # fmt: skip
        self.assertEqual(done.returncode, NO_SOLUTION)
        self.assertIn("in millimetres?", json.loads(done.stdout)["hint"])
        for name, cloud in (("m.xyz", points), ("mm.xyz", large)):
            self.write(name, "".join("%f %f %f\n" % tuple(p) for p in cloud))
        done = self.run_program("register", "m.xyz", "mm.xyz", "--json")
        self.assertEqual(done.returncode, NO_SOLUTION)
        self.assertIn("is one of them in millimetres?", json.loads(done.stdout)["hint"])

    def hint(self, *arguments):
        done = self.run_program("register", *arguments, "--json")
        self.assertEqual(done.returncode, NO_SOLUTION)
        return json.loads(done.stdout)["hint"]

    def test_why_there_is_no_pose(self):
        pairs = ["--correspondences", self.pairs(wrong=60)]
        self.assertIn("--best-effort reports the best one", self.hint(*pairs))
        self.assertIn("near the initial one", self.hint(*pairs, "--initial", IDENTITY))
        rows = (self.folder / "pairs.csv").read_text().splitlines()
        rows = [rows[0] + ",weight", *(row + ",0" for row in rows[1:])]
        self.write("nothing.csv", "\n".join(rows) + "\n")
        self.assertIn("0 of 60 pairs have a weight above 0",
                      self.hint("--correspondences", "nothing.csv"))  # fmt: skip
        self.assertIn("at least four pairs",
                      self.hint("--correspondences", self.pairs(3, 0), "--scale"))  # fmt: skip
        clouds = [self.write("a.xyz", xyz(lump(1))),
                  self.write("b.xyz", xyz(moved(p) for p in lump(2)))]
        self.assertIn("too few features match (1;", self.hint(*clouds, "--set", "features.voxel=1e-9"))
        self.assertIn("near the initial pose", self.hint(*clouds, "--initial", IDENTITY))
        self.assertIn("the noise bound is 10 m", self.hint(*clouds, "--noise-bound", "10"))

    def test_shifted_pairs_have_no_runner_up(self):
        source = random.Random(6)
        rows = ["sx,sy,sz,tx,ty,tz"]
        for _ in range(40):
            p = [source.uniform(-0.05, 0.05) for _ in range(3)]
            rows.append(",".join(f"{v:.9f}" for v in (*p, p[0] + 1, p[1] + 2, p[2] + 3)))
        file = self.write("exact.csv", "\n".join(rows) + "\n")
        for limit in ([], ["--yaw-only"], ["--translation-only"]):
            report = self.run_json("register", "--correspondences", file, *limit)
            self.assertIsNone(report["runner_up"], limit)

    def test_points_that_are_all_the_same_are_said(self):
        for name, cloud in (("lump.xyz", lump(3, 100)), ("same.xyz", [(1, 2, 3)] * 50)):
            self.write(name, "".join("%f %f %f\n" % tuple(p) for p in cloud))
        for clouds, which in ((("same.xyz", "lump.xyz"), "source"), (("lump.xyz", "same.xyz"), "target")):
            done = self.run_program("register", *clouds)
            self.assertEqual(done.returncode, NO_SOLUTION)
            self.assertIn(f"the points of the {which} are all the same", done.stdout)

    def test_a_missing_pose_file_is_named(self):
        self.write("pairs.csv", "sx,sy,sz,tx,ty,tz\n0,0,0,0,0,0\n")
        self.assert_refused(BAD_INPUT, ["certify", "nowhere.txt", "--correspondences", "pairs.csv"],
                            "'nowhere.txt' is neither a file nor")  # fmt: skip
        self.assert_refused(USAGE, ["certify", IDENTITY], "--correspondences", "palpate certify --help")

    def test_wrong_values_are_named(self):
        pairs = ["register", "--correspondences", self.pairs()]
        for value in ("nan", "inf", "0", "-1", "4mm"):
            self.assert_refused(USAGE, [*pairs, "--noise-bound", value],
                                f"--noise-bound: '{value}' is not a positive number")  # fmt: skip
        self.assert_refused(USAGE, [*pairs, "--yaw-only", "--translation-only"], "--yaw-only", "--translation-only")
        self.assert_refused(USAGE, [*pairs, "--gravity", "0", "0", "1", "--translation-only"],
                            "--gravity", "--translation-only")  # fmt: skip
        twice = "2,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1"
        self.assert_refused(BAD_INPUT, ["certify", twice, "--correspondences", "pairs.csv"],
                            "differs from the identity by 3, and the determinant of R is 2")  # fmt: skip

    def test_options_without_effect_are_refused(self):
        pairs = ["register", "--correspondences", "pairs.csv", "--threads", "2"]
        self.assert_refused(USAGE, pairs, "--threads")
        clouds = ["register", "a.ply", "b.ply", "--repeats", "2"]
        self.assert_refused(USAGE, clouds, "--repeats")
        cost = ["register", "--correspondences", "pairs.csv", "--cost", "gm"]
        self.assert_refused(USAGE, cost, "--cost", "--method gnc")

    def test_errors_are_one_line(self):
        file = self.pairs()
        self.write("box.stl", box_stl(0.1, 0.2, 0.3))
        self.write("nan.xyz", "1 2 nan\n")
        self.write("words.xyz", "one two three\n")
        self.write("empty.xyz", "")
        for arguments, code in (
            (["register"], USAGE),
            (["register", "box.stl"], USAGE),
            (["register", "box.stl", "box.stl", "--correspondences", file], USAGE),
            (["register", "box.stl", "box.stl", "--features", "sift"], USAGE),
            (["register", "--correspondences", file, "--filter"], USAGE),
            (["register", "--correspondences", file, "--features", "fpfh"], USAGE),
            (["register", "box.stl", "none.ply"], BAD_INPUT),
            (["register", "box.stl", "nan.xyz"], BAD_INPUT),
            (["register", "box.stl", "words.xyz"], BAD_INPUT),
            (["register", "box.stl", "empty.xyz"], BAD_INPUT),
            (["register", "box.stl", "box.stl", "--noise-bound", "0"], USAGE),
            (["register", "--correspondences", file, "--noise-bound", "-1"], USAGE),
            (["register", "--correspondences", file, "--primitive", "plane"], BAD_INPUT),
            (["register", "--correspondences", file, "--initial", MIRROR], BAD_INPUT),
            (["register", "--correspondences", file, "--initial", IDENTITY, "--method", "gnc"],
             BAD_INPUT),
            (["register", "--correspondences", file, "--normal-noise-deg", "5"], BAD_INPUT),
            (["register", "--correspondences", file, "--instances", "0"], USAGE),
            (["register", "box.stl", "box.stl", "--scale", "--initial", IDENTITY], BAD_INPUT),
            (["register", "box.stl", "box.stl", "--scale", "--instances", "2"], BAD_INPUT),
            (["register", "box.stl", "box.stl", "--initial", IDENTITY,
              "--set", "features.refinements=0"], BAD_INPUT),
            (["register", "box.stl", "box.stl", "--gravity", "0", "0", "0"], BAD_INPUT),
            (["register", "box.stl", "box.stl", "--gravity", "0", "1"], USAGE),
            (["register", "box.stl", "box.stl", "--known-scale", "-1"], USAGE),
            (["register", "box.stl", "box.stl", "--known-scale", "2", "--scale"], USAGE),
            (["certify", "1,2,3", "--correspondences", file], BAD_INPUT),
            (["certify", MIRROR, "--correspondences", file], BAD_INPUT),
            (["certify", IDENTITY, "--correspondences", file, "--noise-bound", "0"], USAGE),
            (["certify", IDENTITY, "--correspondences", file, "--noise-bound", "-1"], USAGE),
            (["certify", IDENTITY, "--correspondences", file, "--set", "x=1"], USAGE),
            (["certify", IDENTITY, "--correspondences", "none.csv"], BAD_INPUT),
        ):
            self.assert_refused(code, arguments)


if __name__ == "__main__":
    main()
