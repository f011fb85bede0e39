# SPDX-License-Identifier: Apache-2.0
"""What the tutorial says that its commands print, but for times and what the machine decides."""

import json
import pathlib
import re
import subprocess

import cli
from cli import DONE, CliTest, main

ROOT = pathlib.Path(__file__).resolve().parents[2]
TUTORIAL = (ROOT / "docs" / "start.md").read_text()
SECONDS = re.compile(r"\d+(\.\d+)? m?s\b")


def shown_after(command):
    """The lines of the text block that follows a command in the tutorial, times left out."""
    block = TUTORIAL.partition(command)[2].partition("```text\n")[2].partition("```")[0]
    return [SECONDS.sub("TIME", line) for line in block.splitlines()]


class Tutorial(CliTest):
    def printed(self, *arguments):
        done = subprocess.run([cli.PROGRAM, *arguments], cwd=ROOT, capture_output=True, text=True)
        self.assertEqual(done.returncode, DONE, done.stderr)
        return [SECONDS.sub("TIME", line) for line in done.stdout.splitlines()]

    def test_the_pose_of_the_bracket(self):
        shown = shown_after("./dev palpate localize bracket examples/bracket.csv")
        self.assertEqual(len(shown), 4)
        self.assertEqual(self.printed("localize", "bracket", "examples/bracket.csv"), shown)

    def test_the_end_of_the_pick(self):
        out = self.folder / "run"
        printed = self.printed("pick", "--object", "mug", "--seed", "2", "--out", str(out))
        pose = next(line for line in printed if line.startswith("pose: "))
        shown = shown_after("./dev demo")
        self.assertIn("pose: certain", shown[0])
        self.assertEqual(pose, shown[0])

    def test_the_three_statements_of_a_registration(self):
        pairs = ["--correspondences", "examples/pairs.csv", "--noise-bound", "0.004"]
        text = "\n".join(self.printed("register", *pairs))
        statements = TUTORIAL.partition("You should see `found: ")[2]
        self.assertIn("found: " + statements.partition("`")[0], text)
        for pattern in (r"is at most (\S+) m\^2 above", r"- (\S+) such poses", r"more than (\d+) inliers"):
            self.assertRegex(text, re.escape(re.search(pattern, statements)[1]) + " (m|such|inliers)")
        report = json.loads("\n".join(self.printed("register", *pairs, "--json")))
        self.assertEqual(report["status"], "found")


if __name__ == "__main__":
    main()
