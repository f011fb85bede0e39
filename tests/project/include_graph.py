# SPDX-License-Identifier: Apache-2.0
"""Checks that every room includes only rooms to its left, and MuJoCo only where it belongs.

usage: include_graph.py REPOSITORY
"""

import pathlib
import re
import sys

ROOMS = (
    "core plotting numerics geometry registration hand tactile grasping localization estimation "
    "planning skills recording ros2 bridge simulation evaluation learning tasks"
).split()
FIRST_WITH_SIMULATOR = "simulation"
INCLUDE = re.compile(r'^\s*#include\s+[<"]([^>"]+)[>"]', re.MULTILINE)


def room_of_header(header):
    """The room of a public ("palpate/ROOM/...") or private ("ROOM/...") header, or None."""
    parts = header.removeprefix("palpate/").split("/")
    return parts[0] if len(parts) > 1 and parts[0] in ROOMS else None


def violations(root):
    bases = (root / "include" / "palpate", root / "src")
    files = [(base, file) for base in bases for file in base.rglob("*.[ch]pp")]
    assert files, f"no sources under {root}"
    for base, file in files:
        room = file.relative_to(base).parts[0]
        if room not in ROOMS:
            yield f"{file.relative_to(root)}: {room} is no room"
            continue
        for header in INCLUDE.findall(file.read_text()):
            included = room_of_header(header)
            if included and ROOMS.index(included) > ROOMS.index(room):
                yield f"{file.relative_to(root)}: {room} may not include {header}"
            if header.startswith("mujoco/") and ROOMS.index(room) < ROOMS.index(FIRST_WITH_SIMULATOR):
                yield f"{file.relative_to(root)}: {room} may not include {header}"


if __name__ == "__main__":
    found = list(violations(pathlib.Path(sys.argv[1])))
    print("\n".join(found) or "the include graph follows the order of the rooms")
    sys.exit(bool(found))
