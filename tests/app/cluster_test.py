# SPDX-License-Identifier: Apache-2.0
"""The recipes for many machines: the same bytes as one run, and nothing lost with a worker."""

import importlib.util
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time
import unittest

import cli
from cli import BAD_INPUT, DONE, QUICK, CliTest, main

RECIPES = pathlib.Path(__file__).resolve().parents[2] / "examples" / "cluster"
TOOLS = ["xargs", *(["parallel"] if shutil.which("parallel") else [])]
TRIALS = ["--object", "box", "--trials", "4", "--seed", "3", *QUICK]


class Cluster(CliTest):
    def setUp(self):
        super().setUp()
        self.environment = dict(os.environ, PALPATE=cli.PROGRAM, PALPATE_CACHE=str(self.cache))

    def single(self):
        self.run_json("eval", *TRIALS, "--out", "single")
        return (self.folder / "single/eval.json").read_bytes()

    def start(self, *command, **more):
        program = subprocess.Popen(
            command, cwd=self.folder, env=dict(self.environment, **more), stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)  # fmt: skip
        self.addCleanup(program.kill)
        return program

    def kill_a_part(self, folder, top, worker=False):
        """Kills, without warning, the program of the first part once it has done a trial, or the
        worker that runs it."""
        for _ in range(1200):
            for process in pathlib.Path("/proc").glob("[0-9]*"):
                try:
                    words = (process / "cmdline").read_bytes().split(b"\0")
                except OSError:
                    continue
                begun = (self.folder / folder / "part1" / "trials.jsonl").exists()
                if b"eval" in words and str(top).encode() in b" ".join(words) and b"1/" in b" ".join(words):
                    if begun and words[0] == cli.PROGRAM.encode():
                        parent = int((process / "stat").read_text().rpartition(")")[2].split()[1])
                        os.kill(parent if worker else int(process.name), signal.SIGKILL)
                        return True
            time.sleep(0.05)
        return False

    def test_parts_of_an_evaluation_of_which_one_is_killed(self):
        expected = self.single()
        for tool in TOOLS:
            top = self.folder / tool
            program = self.start("sh", str(RECIPES / "parallel.sh"), str(top), *TRIALS,
                                 SHARDS="2", JOBS="2", PARTS_BY=tool)  # fmt: skip
            self.assertTrue(self.kill_a_part(tool, top))
            _, stderr = program.communicate(timeout=500)
            self.assertEqual(program.returncode, DONE, stderr)
            self.assertEqual((top / "whole/eval.json").read_bytes(), expected, tool)

    def test_a_part_that_always_fails_ends_the_recipe(self):
        for tool in TOOLS:
            program = self.start("sh", str(RECIPES / "parallel.sh"), str(self.folder / tool), "--object", "none.stl",
                                 SHARDS="2", JOBS="2", PARTS_BY=tool)  # fmt: skip
            _, stderr = program.communicate(timeout=100)
            self.assertNotEqual(program.returncode, DONE)
            self.assertIn("none.stl", stderr)
            self.assertFalse((self.folder / tool / "whole").exists())

    def test_several_machines_need_gnu_parallel(self):
        program = self.start("sh", str(RECIPES / "parallel.sh"), str(self.folder / "many"), *TRIALS,
                             PARTS_BY="xargs", PARALLEL="--sshloginfile nodes")  # fmt: skip
        _, stderr = program.communicate(timeout=100)
        self.assertEqual(program.returncode, BAD_INPUT)
        self.assertIn("GNU parallel is not installed", stderr)

    def test_a_search_whose_rollouts_run_in_parts(self):
        tiny = ["--iterations", "2", "--seed", "3", "--episodes", "2",
                "--set", "cem.search.cem.population=4", "--set", "cem.search.cem.elite=2",
                "--set", "cem.search.screening=1", "--set", "cem.search.episodes=2",
                "--set", "cem.search.episode.horizon=5"]  # fmt: skip
        self.run_json("train", "relocate", *tiny, "--out", "one")
        for tool in TOOLS:
            program = self.start("sh", str(RECIPES / "cem.sh"), str(self.folder / tool), *tiny,
                                 SHARDS="3", JOBS="2", PARTS_BY=tool)  # fmt: skip
            _, stderr = program.communicate(timeout=500)
            self.assertEqual(program.returncode, DONE, stderr)
            for name in ("policy.json", "checkpoint", "curves.csv"):
                self.assertEqual((self.folder / tool / name).read_bytes(),
                                 (self.folder / "one" / name).read_bytes(), (tool, name))  # fmt: skip

    def test_a_slurm_array_with_a_job_requeued(self):
        expected = self.single()
        top = self.folder / "array"
        script = RECIPES / "slurm_array.sh"
        subprocess.run(["sh", "-n", str(script)], check=True)
        for task in ("1", "2", "2", "3"):  # the second twice: as requeued
            program = self.start("sh", str(script), str(top), *TRIALS, SLURM_ARRAY_TASK_ID=task,
                                 SLURM_ARRAY_TASK_COUNT="3")  # fmt: skip
            _, stderr = program.communicate(timeout=500)
            self.assertEqual(program.returncode, DONE, stderr)
        self.run_json("merge", *(f"array/part{i}/trials.jsonl" for i in (3, 1, 2)), "--out", "whole")
        self.assertEqual((self.folder / "whole/eval.json").read_bytes(), expected)
        manifest = json.loads((top / "part2/manifest.json").read_text())
        self.assertEqual((manifest["shard"], manifest["trials"]), ("2/3", 4))
        self.assertEqual(len(manifest["configuration"]), len(
            json.loads((self.folder / "single/manifest.json").read_text())["configuration"]))
        self.assertGreaterEqual(manifest["machine"]["cores"], 1)
        self.assertRegex(manifest["commit"], r"^([0-9a-f]{12}(-dirty)?|unknown)$")

    def test_the_recipe_for_ray_with_a_stand_in(self):
        stand_in = self.folder / "stand_in"
        stand_in.mkdir()
        (stand_in / "ray.py").write_text(
            "def init(**_): pass\n"
            "def get(results): return results\n"
            "def remote(**_):\n"
            "    def made(task):\n"
            "        task.remote = task\n"
            "        return task\n"
            "    return made\n")  # fmt: skip
        expected = self.single()
        program = self.start(sys.executable, str(RECIPES / "ray_eval.py"), str(self.folder / "ray"), "--shards", "2",
                             "--palpate", cli.PROGRAM, "--", *TRIALS, PYTHONPATH=str(stand_in))  # fmt: skip
        _, stderr = program.communicate(timeout=500)
        self.assertEqual(program.returncode, DONE, stderr)
        self.assertEqual((self.folder / "ray/whole/eval.json").read_bytes(), expected)

    @unittest.skipUnless(importlib.util.find_spec("ray"), "Ray is not installed (pip install ray); a stand-in was tried")
    def test_ray_with_a_worker_killed(self):
        expected = self.single()
        top = self.folder / "ray"
        program = self.start(sys.executable, str(RECIPES / "ray_eval.py"), str(top), "--shards", "2",
                             "--palpate", cli.PROGRAM, "--", *TRIALS)  # fmt: skip
        self.assertTrue(self.kill_a_part("ray", top, worker=True))
        _, stderr = program.communicate(timeout=500)
        self.assertEqual(program.returncode, DONE, stderr)
        self.assertEqual((top / "whole/eval.json").read_bytes(), expected)


if __name__ == "__main__":
    main()
