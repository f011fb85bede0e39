# SPDX-License-Identifier: Apache-2.0
"""The bench command: the table of what a fingertip may collide with."""

import json

from cli import BAD_INPUT, USAGE, CliTest, box_stl, main


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

    def test_errors_are_one_line(self):
        self.write("speck.stl", box_stl(0.004, 0.004, 0.004))
        for arguments, code in (
            (["bench"], USAGE),
            (["bench", "contact", "--probes", "0"], USAGE),
            (["bench", "contact", "--object", "teapot"], BAD_INPUT),
            (["bench", "contact", "--object", "speck.stl"], BAD_INPUT),
        ):
            self.assert_refused(code, arguments)


if __name__ == "__main__":
    main()
