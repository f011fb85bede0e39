# SPDX-License-Identifier: Apache-2.0
"""The scripts that teach run as they are. PALPATE_EXAMPLES: their folder, if not beside this one."""

import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

try:
    from matplotlib import image
except ImportError:
    image = None

FOLDER = pathlib.Path(
    os.environ.get("PALPATE_EXAMPLES", pathlib.Path(__file__).parents[2] / "examples" / "python")
)


class Examples(unittest.TestCase):
    def require(self, module):
        """Skips the test without it; sought by a process of its own, as the script does."""
        found = subprocess.run([sys.executable, "-c", f"import {module}"], capture_output=True)
        if found.returncode != 0:
            self.skipTest(f"{module} is not installed (pip install {module.replace('_', '-')})")

    def run_and_draw(self, name):
        """The script's output; where matplotlib is there, its figure must show something."""
        if not image:
            return self.run_example(name)
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "figure.png"
            text = self.run_example(name, "--figure", file)
            pixels = image.imread(file)[:, :, :3]
            self.assertGreater(pixels.shape[1], 800)
            self.assertGreater((pixels.min(axis=2) < 0.9).mean(), 0.02)  # not white
        return text

    def run_example(self, name, *arguments):
        done = subprocess.run(
            [sys.executable, FOLDER / name, *arguments], capture_output=True, text=True, timeout=540,
            env={**os.environ, "MPLBACKEND": "agg"},
        )  # fmt: skip
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def test_localize(self):
        text = self.run_and_draw("localize.py")
        self.assertRegex(text, r"Posterior\((certain|ambiguous)")
        self.assertIn("without normals:", text)

    def test_own_hand(self):
        self.require("palpate.sim")
        text = self.run_and_draw("own_hand.py")
        self.assertRegex(text, r"PickResult\((held|failed)")
        self.assertRegex(text, r"largest force that a finger sensed: [1-9]")

    def test_hand_in_another_engine(self):
        self.require("palpate.sim")
        self.require("sapien")
        text = self.run_example("hand_in_sapien.py", "--trials", "1", "--seed", "1")
        self.assertIn("1 of 1 lifted, 1 with the right pose", text)

    def test_learn_touch(self):
        self.require("stable_baselines3")
        text = self.run_example("learn_touch.py", "--minutes", "0.05", "--episodes", "2")
        self.assertRegex(text, r"chance: return .* of 2 poses right")
        self.assertRegex(text, r"learnt: return .* of 2 poses right")

    def test_learn_relocate(self):
        self.require("palpate.sim")
        self.require("stable_baselines3")
        with tempfile.TemporaryDirectory() as folder:
            text = self.run_example("learn_relocate.py", "--steps", "4096", "--episodes", "2",
                                    "--out", folder)  # fmt: skip
            self.assertRegex(text, r"4096 steps: return -?\d")
            self.assertRegex(text, r"2 fresh starts: return .* within 10, 5, 2 cm: 0\.00")
            files = {path.name for path in pathlib.Path(folder).iterdir()}
            self.assertEqual(files, {"policy.zip", "scales.pkl", "curve.csv"})

    def test_register(self):
        text = self.run_and_draw("register.py")
        self.assertIn("RegistrationResult(found, 30 inliers", text)
        self.assertIn("PoseEstimate(certified", text)
        self.assertIn("CloudRegistration(", text)


if __name__ == "__main__":
    unittest.main()
