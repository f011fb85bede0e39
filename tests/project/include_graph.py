# SPDX-License-Identifier: Apache-2.0
"""Checks that every module includes only modules to its left, and MuJoCo only where it belongs."""

import pathlib
import re
import sys

MODULES = (
    "core geometry registration hand touch recording localization simulation planning learning "
    "pipeline"
).split()
SIMULATOR_HEADERS_ALLOWED_IN = {"hand", "simulation"}
INCLUDE = re.compile(r'^\s*#include\s+[<"]([^>"]+)[>"]', re.MULTILINE)


def violations(root):
    files = [*root.glob("include/palpate/*/*.hpp"), *root.glob("src/*/*.[ch]pp")]
    assert files, f"no sources under {root}"
    for file in files:
        module = file.parent.name
        for header in INCLUDE.findall(file.read_text()):
            included = header.split("/")[1] if header.startswith("palpate/") else None
            if included and MODULES.index(included) > MODULES.index(module):
                yield f"{file.relative_to(root)}: {module} may not include {header}"
            if header.startswith("mujoco/") and module not in SIMULATOR_HEADERS_ALLOWED_IN:
                yield f"{file.relative_to(root)}: {module} may not include {header}"


if __name__ == "__main__":
    found = list(violations(pathlib.Path(sys.argv[1])))
    print("\n".join(found) or "the include graph follows the order of the modules")
    sys.exit(bool(found))
