# SPDX-License-Identifier: Apache-2.0
"""The bench command: the table of what a fingertip may collide with."""

import json
import pathlib
import subprocess
import sys

import cli
from cli import BAD_INPUT, USAGE, CliTest, box_stl, main

SCALING = pathlib.Path(__file__).resolve().parents[2] / "bench" / "scaling.py"


class BenchContact(CliTest):
    def test_true_surface_is_met_exactly(self):
        report = self.run_json(
            "bench", "contact", "--object", "bracket", "--quick", "--out", "bench"
        )
        results = report["representations"]
        self.assertEqual(set(results), {"hull", "parts", "sdf", "flex", "exact"})
        for result in results.values():
            self.assertGreater(result["microseconds"], 0)
        exact = results["exact"]
        self.assertEqual(exact["missed"], 0)
        self.assertLess(exact["angle_deg"]["median"], 0.5)
        self.assertLess(exact["angle_deg"]["p95"], 2)
        self.assertLess(exact["position_mm"]["p95"], 0.2)
        self.assertGreater(results["hull"]["position_mm"]["max"], 1)
        for tips in ("exact", "parts"):
            self.assertGreater(report["grasp"][tips]["contacts"], 1)
        self.assertEqual(json.loads((self.folder / "bench/contact.json").read_text()), report)

    def test_results_that_are_there_are_named_before_anything_is_measured(self):
        (self.folder / "bench").mkdir()
        self.write("bench/contact.json", "kept")
        command = ["bench", "contact", "--quick", "--out", "bench"]
        self.assert_refused(BAD_INPUT, command, "bench/contact.json is there already")

    def test_errors_are_one_line(self):
        self.write("speck.stl", box_stl(0.004, 0.004, 0.004))
        for arguments, code in (
            (["bench"], USAGE),
            (["bench", "contact", "--probes", "0"], USAGE),
            (["bench", "contact", "--object", "teapot"], BAD_INPUT),
            (["bench", "contact", "--object", "speck.stl"], BAD_INPUT),
        ):
            self.assert_refused(code, arguments)


class Scaling(CliTest):
    def modelled(self, count, cores, **changed):
        parts = {"start": 2.0, "trials": [10.0], "merge": 0.001, "bytes": 1000, "sync": 0.5,
                 "search": {"episode": 1.0, "start_of_a_share": 0.5, "ask": 0.5, "tell": 0.25}}  # fmt: skip
        self.write("parts.json", json.dumps(parts | changed))
        done = subprocess.run(
            [sys.executable, str(SCALING), cli.PROGRAM, "--parts", "parts.json", "--of", str(count), "--cores",
             str(cores), "--price", "0.5"], cwd=self.folder, capture_output=True, text=True, check=True)  # fmt: skip
        return json.loads(done.stdout)["modelled"][str(cores)]

    def test_equal_trials_take_what_they_must(self):
        model = self.modelled(1000, 100)
        merge = 2.0 + 1000 * 0.001
        self.assertAlmostEqual(model["static"]["seconds"], 2 + 10 * 10.5 + merge, places=1)
        self.assertAlmostEqual(model["fine"]["seconds"], 10 * (2 + 10.5) + merge, places=1)
        self.assertEqual(model["fine"]["most_lost_by"], "starts")
        self.assertAlmostEqual(model["cost"]["static"], 0.5 * model["static"]["core_hours"], places=2)
        # 48 candidates twice, then 24 of them four times, each by a core of its own.
        self.assertAlmostEqual(model["search"]["seconds"], 2 * (0.5 + 0.25) + 2 + 4, places=2)

    def test_the_last_core_is_waited_for(self):
        model = self.modelled(1000, 100, trials=[1.0] * 9 + [91.0], sync=0)
        self.assertEqual(model["static"]["most_lost_by"], "waiting for the last core")
        self.assertGreater(model["static"]["seconds"], 2 * 100)
        self.assertLess(model["static"]["efficiency"], 0.5)


if __name__ == "__main__":
    main()
