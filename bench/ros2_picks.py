# SPDX-License-Identifier: Apache-2.0
"""Picks through ROS 2 beside the same picks in one process.

usage: ros2_picks.py PALPATE [--objects box,mug] [--trials 10] [--seed 0]

Each trial picks once in one process and once by two programs that exchange messages over the
loopback: `palpate ros2 robot`, which simulates hand and object, and `palpate ros2 pick`. Prints, as
JSON, what became of each, and how many were held at the end (lifted, of the simulated truth).
"""

import argparse
import json
import os
import pathlib
import random
import signal
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "tests" / "app"))

from ros2_loopback import LOOPBACK

LIFTED = 0.05  # m, that the object has risen


def report_of(program):
    stdout, stderr = program.communicate()
    if not stdout.strip():
        sys.exit(f"{' '.join(program.args)}: {stderr}")
    return json.loads(stdout)


class Trial:
    def __init__(self, palpate, name, seed, folder):
        self.palpate, self.folder = palpate, folder
        self.options = ["--object", name, "--seed", str(seed), "--json", "--quiet"]
        self.domain = ["--domain", str(random.SystemRandom().randrange(1, 230))]

    def start(self, *arguments):
        return subprocess.Popen([self.palpate, *arguments, *self.options], text=True,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE)  # fmt: skip

    def alone(self):
        began = time.monotonic()
        report = report_of(self.start("pick", "--out", str(self.folder), "--force", "--no-belief"))
        return {"status": report["status"], "held": report["lifted"], "attempts": report["attempts"],
                "robot_seconds": report["robot_seconds"], "seconds": time.monotonic() - began}  # fmt: skip

    def through_ros2(self):
        began = time.monotonic()
        robot = self.start("ros2", "robot", *self.domain)
        report = report_of(self.start("ros2", "pick", "--perturb-links", "--timeout", "30", *self.domain))
        robot.send_signal(signal.SIGINT)
        truth = report_of(robot)
        return {"status": report["status"], "held": truth["risen"] > LIFTED, "attempts": report["attempts"],
                "robot_seconds": report["robot_seconds"], "repeats": report["repeats"],
                "malformed": report["received"]["malformed"], "seconds": time.monotonic() - began}  # fmt: skip


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("palpate")
    parser.add_argument("--objects", default="box,mug")
    parser.add_argument("--trials", type=int, default=10)
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    os.environ["CYCLONEDDS_URI"] = LOOPBACK
    trials = []
    with tempfile.TemporaryDirectory() as folder:
        for name in arguments.objects.split(","):
            for seed in range(arguments.seed, arguments.seed + arguments.trials):
                trial = Trial(arguments.palpate, name, seed, pathlib.Path(folder) / "pick")
                done = {"object": name, "seed": seed, "alone": trial.alone(), "ros2": trial.through_ros2()}
                print(json.dumps(done), file=sys.stderr, flush=True)
                trials.append(done)
    held = {way: sum(trial[way]["held"] for trial in trials) for way in ("alone", "ros2")}
    same = sum(trial["alone"]["status"] == trial["ros2"]["status"] for trial in trials)
    print(json.dumps({"trials": len(trials), "held": held, "same_status": same, "each": trials}, indent=1))


if __name__ == "__main__":
    main()
