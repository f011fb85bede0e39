# SPDX-License-Identifier: Apache-2.0
"""Checks that no file asks the simulator for what is true that has no business to.

usage: truth.py REPOSITORY

Outside the simulator, that is; tests, experiments and benchmarks may ask.
"""

import pathlib
import re
import sys

FOLDERS = ("include", "src", "apps", "python")
SIMULATOR = ("src/simulation/world/world", "src/simulation/world/simulated_hand",
             "src/simulation/world/object_step", "include/palpate/simulation/world/")  # fmt: skip
ASKS = re.compile(r"(\.|->)\s*truth\(\)|\bObjectStep\b|\bStepObserver\b")
MAY_ASK = {
    "src/evaluation/evaluator.cpp": "compares with it, after the pick",
    "src/evaluation/recorder.cpp": "records it beside the estimate",
    "src/simulation/world/open_loop_grasp.cpp": "says whether the object hangs: a grasp by script",
    "apps/palpate/ros2.cpp": "`palpate ros2 robot` reports at its end where the object is",
    "apps/palpate/bench.cpp": "counts contacts of a grasp by script",
    "python/sim/world.cpp": "a script may ask a simulated world, as a test may",
}


def main(root):
    asking = set()
    for folder in FOLDERS:
        for file in (root / folder).rglob("*.[ch]pp"):
            name = file.relative_to(root).as_posix()
            if not name.startswith(SIMULATOR) and ASKS.search(file.read_text()):
                asking.add(name)
    faults = [f"{file} asks for the truth; who may is listed here" for file in asking - MAY_ASK.keys()]
    faults += [f"{file} no longer asks for the truth" for file in MAY_ASK.keys() - asking]
    print("\n".join(sorted(faults)) or f"{len(asking)} files ask for the truth, all on the list")
    return bool(faults)


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1]).resolve()))
