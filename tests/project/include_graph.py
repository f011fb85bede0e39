# SPDX-License-Identifier: Apache-2.0
"""Checks that every library includes only those to its left, and MuJoCo only where it belongs.

usage: include_graph.py REPOSITORY
"""

import pathlib
import re
import sys

LIBRARIES = (
    "core plotting numerics geometry registration hand tactile grasping localization estimation "
    "planning skills recording ros2 bridge simulation evaluation learning tasks"
).split()
FIRST_WITH_SIMULATOR = "simulation"
INCLUDE = re.compile(r'^\s*#include\s+[<"]([^>"]+)[>"]', re.MULTILINE)


def library_of_header(header):
    """The library of a header, public ("palpate/LIBRARY/...") or private, or None."""
    parts = header.removeprefix("palpate/").split("/")
    return parts[0] if len(parts) > 1 and parts[0] in LIBRARIES else None


def violations(root):
    bases = (root / "include" / "palpate", root / "src")
    files = [(base, file) for base in bases for file in base.rglob("*.[ch]pp")]
    assert files, f"no sources under {root}"
    for base, file in files:
        library = file.relative_to(base).parts[0]
        if library not in LIBRARIES:
            yield f"{file.relative_to(root)}: {library} is not a library of Palpate"
            continue
        for header in INCLUDE.findall(file.read_text()):
            included = library_of_header(header)
            if included and LIBRARIES.index(included) > LIBRARIES.index(library):
                yield f"{file.relative_to(root)}: {library} may not include {header}"
            early = LIBRARIES.index(library) < LIBRARIES.index(FIRST_WITH_SIMULATOR)
            if header.startswith("mujoco/") and early:
                yield f"{file.relative_to(root)}: {library} may not include {header}"


if __name__ == "__main__":
    found = list(violations(pathlib.Path(sys.argv[1])))
    print("\n".join(found) or "the include graph follows the order of the libraries")
    sys.exit(bool(found))
