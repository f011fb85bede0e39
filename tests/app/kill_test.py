# SPDX-License-Identifier: Apache-2.0
"""Kills at random times: what is on the disk is complete or absent, and the repeated run ends like
one that nobody killed, byte for byte.

PALPATE_KILLS=N kills each command N times (`./dev kills N`); the default is 3.
"""

import json
import os
import pathlib
import random
import shutil
import signal
import subprocess
import time

import cli
from cli import DONE, QUICK, CliTest, main

KILLS = int(os.environ.get("PALPATE_KILLS", "3"))
# A pick of a second or two, of which only the form matters.
SHORT = [*QUICK, "--quiet", "--set", "calibrate.touches=0", "--set", "attempts=1",
         "--set", "palpation.max=0", "--set", "explore.touches=0", "--set", "explore.max_touches=0",
         "--set", "estimate_before_lift=false"]  # fmt: skip
# Hardly any search and no touches before the grasp: that holds in an ideal world alone.
IDEAL = str(pathlib.Path(__file__).resolve().parents[2] / "configs" / "ideal.toml")
EVAL = ["eval", "--object", "box", "--seed", "40", *SHORT]
TRAIN = ["train", "relocate", "--iterations", "40", "--seed", "3", "--quiet", "--episodes", "2",
         "--set", "cem.search.cem.population=4", "--set", "cem.search.cem.elite=2",
         "--set", "cem.search.screening=1", "--set", "cem.search.episodes=1",
         "--set", "cem.search.episode.horizon=20"]  # fmt: skip


def without_times(text):
    """A report, or a line of one, without what a clock measured."""

    def strip(value):
        if isinstance(value, dict):
            return {key: strip(item) for key, item in value.items()
                    if not key.endswith("seconds") and not key.endswith("per_second")}  # fmt: skip
        return [strip(item) for item in value] if isinstance(value, list) else value

    return strip(json.loads(text))


def contents(folder, names=None):
    """Name to bytes, or to values for reports, of the files that a run finished."""
    found = {}
    for path in sorted(folder.rglob("*")):
        if path.is_dir() or path.name.endswith(".partial"):
            continue
        if names is not None and path.name not in names:
            continue
        data = path.read_bytes()
        found[path.name] = without_times(data) if path.name == "report.json" else data
    return found


class Kills(CliTest):
    def setUp(self):
        super().setUp()
        self.chance = random.Random(11)

    def start(self, *arguments):
        return subprocess.Popen(
            [cli.PROGRAM, *arguments], cwd=self.folder, stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL, env=dict(os.environ, PALPATE_CACHE=str(self.cache)),
        )  # fmt: skip

    def run_whole(self, *arguments):
        """@return s that it took"""
        begin = time.monotonic()
        self.assertEqual(self.start(*arguments).wait(), DONE, arguments)
        return time.monotonic() - begin

    def kill_often(self, arguments, seconds, after_kill, after_end):
        """Starts and kills the command until it was killed KILLS times.

        @param seconds  up to which it may run before a kill
        @param after_end  for runs that ended before they were to be killed; begins from nothing
        """
        killed = 0
        while killed < KILLS:
            process = self.start(*arguments)
            time.sleep(self.chance.uniform(0, seconds))
            process.send_signal(signal.SIGKILL)
            if process.wait() == -signal.SIGKILL:
                killed += 1
                after_kill()
            else:
                self.assertEqual(process.returncode, DONE)
                after_end()
        self.run_whole(*arguments)
        after_end()
        print(f"{arguments[0]}: killed {killed} times, nothing lost", flush=True)

    def check_finished_files(self, name, whole):
        """Each file under its final name is that of the run that nobody killed."""
        for path, data in contents(self.folder / name).items():
            self.assertEqual(data, whole[path], path)

    def test_pick(self):
        command = ["pick", "--object", "box", "--seed", "1", "--json", "--no-belief", "--config",
                   IDEAL, *SHORT]
        self.run_whole(*command, "--out", "whole")  # fills the cache, too
        seconds = self.run_whole(*command, "--out", "whole", "--force")
        whole = contents(self.folder / "whole")
        self.assertIn("recording.h5", whole)

        def end():
            self.assertEqual(contents(self.folder / "part"), whole)

        self.kill_often([*command, "--out", "part", "--force"], seconds,
                        lambda: self.check_finished_files("part", whole), end)  # fmt: skip
        self.assertFalse(list((self.folder / "part").glob("*.partial")))

    def test_cache(self):
        command = ["pick", "--object", "box", "--seed", "1", "--json", "--no-belief", "--config",
                   IDEAL, *SHORT]
        seconds = self.run_whole(*command, "--out", "whole")
        whole, entries = contents(self.folder / "whole"), contents(self.cache)
        self.assertGreater(len(entries), 0)
        shutil.rmtree(self.cache)

        def kept():
            found = contents(self.cache)
            self.assertLessEqual(found.items(), entries.items())

        def end():
            self.assertEqual(contents(self.folder / "part"), whole)
            self.assertEqual(contents(self.cache), entries)
            shutil.rmtree(self.cache)

        self.kill_often([*command, "--out", "part", "--force"], seconds, kept, end)

    def test_eval(self):
        command = [*EVAL, "--trials", "2", "--json"]
        seconds = self.run_whole(*command, "--out", "whole")
        results = ("eval.json", "trials.csv", "config.toml")
        whole = contents(self.folder / "whole", results)
        lines = [without_times(line) for line in self.read_lines("whole")]
        part = self.folder / "part"
        rows = []

        def kept():  # all lines but the last are complete, none that was there is gone
            now = self.read_lines("part") if (part / "trials.jsonl").exists() else []
            self.assertEqual([without_times(line) for line in now], lines[: len(now)])
            self.assertGreaterEqual(len(now), len(rows))
            self.assertEqual(now[: len(rows)], rows)
            rows[:] = now

        def end():
            kept()
            self.assertEqual(contents(part, results), whole)
            shutil.rmtree(part)
            rows.clear()

        self.kill_often([*command, "--out", "part"], seconds, kept, end)

    def read_lines(self, name):
        """The complete ones."""
        data = (self.folder / name / "trials.jsonl").read_bytes()
        return data[: data.rfind(b"\n") + 1].splitlines()

    def test_merge(self):
        both = [*EVAL, "--trials", "2"]
        self.run_whole(*both, "--out", "one", "--shard", "1/2")
        self.run_whole(*both, "--out", "two", "--shard", "2/2")
        parts = [contents(self.folder / name) for name in ("one", "two")]
        command = ["merge", "one", "two", "--json", "--out"]
        seconds = self.run_whole(*command, "whole")
        whole = contents(self.folder / "whole")
        self.assertIn("eval.json", whole)

        def kept():
            self.assertEqual([contents(self.folder / name) for name in ("one", "two")], parts)
            if (self.folder / "all" / "eval.json").exists():
                self.assertEqual((self.folder / "all" / "eval.json").read_bytes(),
                                 whole["eval.json"])  # fmt: skip

        def end():
            kept()
            self.assertEqual(contents(self.folder / "all"), whole)

        self.kill_often([*command, "all", "--force"], seconds, kept, end)

    def test_train(self):
        seconds = self.run_whole(*TRAIN, "--out", "whole")
        names = ("policy.json", "curves.csv", "elite.svg", "best.svg", "report.json", "config.toml")
        whole = contents(self.folder / "whole", names)
        self.assertIn("policy.json", whole)

        def kept():  # the policy so far is whole
            policy = self.folder / "part" / "policy.json"
            if policy.exists():
                json.loads(policy.read_text())

        def end():
            self.assertEqual(contents(self.folder / "part", names), whole)
            shutil.rmtree(self.folder / "part")

        self.kill_often([*TRAIN, "--out", "part"], seconds, kept, end)


if __name__ == "__main__":
    main()
