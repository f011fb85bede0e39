# SPDX-License-Identifier: Apache-2.0
"""An evaluation in parts on a Ray cluster whose nodes share the folder.

usage: ray_eval.py OUT --shards N [--palpate PROGRAM] -- [arguments of palpate eval]

A part whose worker dies is started again elsewhere and goes on where it was; the merged report is
that of one run, bit for bit. `ray.init()` takes RAY_ADDRESS; without it, this machine is used.
"""

import argparse
import ctypes
import pathlib
import signal
import subprocess
import sys

import ray


PR_SET_PDEATHSIG = 1  # Linux


def end_with_worker():
    """So that a part whose worker was killed does not hold its folder against the next one."""
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)


@ray.remote(num_cpus=1, max_retries=5, retry_exceptions=True)
def run_part(command):
    subprocess.run(command, stdout=subprocess.DEVNULL, preexec_fn=end_with_worker, check=True)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--shards", type=int, required=True)
    parser.add_argument("--palpate", default="palpate")
    words = sys.argv[1:]
    at = words.index("--") if "--" in words else len(words)
    given, rest = parser.parse_args(words[:at]), words[at + 1 :]
    out = given.out.absolute()
    out.mkdir(parents=True, exist_ok=True)
    ray.init(log_to_driver=False)
    parts = [out / f"part{i}" for i in range(1, given.shards + 1)]
    ray.get([
        run_part.remote([given.palpate, "eval", "--quiet", *rest,
                         "--shard", f"{i}/{given.shards}", "--out", str(part)])
        for i, part in enumerate(parts, 1)
    ])  # fmt: skip
    subprocess.run([given.palpate, "merge", *map(str, parts), "--out", str(out / "whole")], check=True)


if __name__ == "__main__":
    main()
