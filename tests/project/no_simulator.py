# SPDX-License-Identifier: Apache-2.0
"""Checks that programs do without the simulator: none loads MuJoCo, directly or by another library.

Usage: no_simulator.py PROGRAM...
"""

import subprocess
import sys


def libraries(program):
    """Lines of what the dynamic linker loads for a program."""
    done = subprocess.run(["ldd", program], capture_output=True, text=True, check=True)
    return [line.strip() for line in done.stdout.splitlines()]


def main():
    programs = sys.argv[1:]
    if not programs:
        sys.exit("no program to check")
    wrong = 0
    for program in programs:
        loaded = libraries(program)
        if not any("libc.so" in line for line in loaded):
            sys.exit(f"{program}: ldd lists no libraries: {loaded}")
        for line in loaded:
            if "mujoco" in line.lower():
                print(f"{program} loads the simulator: {line}")
                wrong += 1
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
