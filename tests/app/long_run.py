# SPDX-License-Identifier: Apache-2.0
"""Pick after pick in one process: its memory after each, and what is left in the folders.

Usage: long_run.py PALPATE [PICKS [ARGUMENT OF eval...]]

The program evaluates PICKS (100) picks of one object in one process. Of each pick the least
resident memory counts. Prints the medians of the second and the last fifth of the picks
and their ratio; ends with 1 if it exceeds 1.01, or if a file is left behind.
"""

import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

RESULTS = {"trials.jsonl", "trials.csv", "eval.json", "config.toml", "manifest.json"}


def resident_kb(pid):
    for line in pathlib.Path(f"/proc/{pid}/status").read_text().splitlines():
        if line.startswith("VmRSS:"):
            return int(line.split()[1])
    return None  # it has just ended


def rows(path):
    return path.read_bytes().count(b"\n") - 1 if path.exists() else 0


def watch(process, table):
    """@return the least resident memory during each pick, kB"""
    memory, least = [], None
    while process.poll() is None:
        kb = resident_kb(process.pid)
        if kb is None:
            return memory
        least = min(kb, least or kb)
        if len(memory) < rows(table):
            memory.append(least)
            least = None
        time.sleep(0.05)
    return memory


def main():
    program, picks = os.path.abspath(sys.argv[1]), int((sys.argv[2:] or ["100"])[0])
    with tempfile.TemporaryDirectory() as folder:
        temporary = pathlib.Path(folder, "tmp")
        temporary.mkdir()
        out = pathlib.Path(folder, "out")
        process = subprocess.Popen(
            [program, "eval", "--object", "box", "--trials", str(picks), "--seed", "40",
             "--threads", "1", "--quiet", "--out", str(out), *sys.argv[3:]],
            stdout=subprocess.DEVNULL, env=dict(os.environ, TMPDIR=str(temporary)),
        )  # fmt: skip
        memory = watch(process, out / "trials.jsonl")
        left = {path.name for path in [*out.iterdir(), *temporary.iterdir()]} - RESULTS
    if process.returncode != 0:
        return process.returncode
    fifth = max(1, len(memory) // 5)
    early, late = statistics.median(memory[fifth : 2 * fifth]), statistics.median(memory[-fifth:])
    print(f"{len(memory)} picks, {early / 1024:.1f} MB early, {late / 1024:.1f} MB late, "
          f"ratio {late / early:.4f}, left behind: {sorted(left) or 'nothing'}")  # fmt: skip
    return 0 if late / early <= 1.01 and not left else 1


if __name__ == "__main__":
    sys.exit(main())
