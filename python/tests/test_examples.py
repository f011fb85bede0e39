# SPDX-License-Identifier: Apache-2.0
"""The scripts that teach run as they are. PALPATE_EXAMPLES: their folder, if not beside this one."""

import os
import pathlib
import subprocess
import sys
import unittest

FOLDER = pathlib.Path(
    os.environ.get("PALPATE_EXAMPLES", pathlib.Path(__file__).parents[2] / "examples" / "python")
)


class Examples(unittest.TestCase):
    def run_example(self, name):
        done = subprocess.run(
            [sys.executable, FOLDER / name], capture_output=True, text=True, timeout=300
        )
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def test_localize(self):
        text = self.run_example("localize.py")
        self.assertRegex(text, r"Posterior\((certain|ambiguous)")
        self.assertIn("without normals:", text)

    def test_register(self):
        text = self.run_example("register.py")
        self.assertIn("RegistrationResult(found, 30 inliers", text)
        self.assertIn("PoseEstimate(certified", text)
        self.assertIn("CloudRegistration(", text)


if __name__ == "__main__":
    unittest.main()
