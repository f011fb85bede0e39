# SPDX-License-Identifier: Apache-2.0
"""One version everywhere: CMake, the Python and ROS 2 packages, the Dockerfile, the citation, the
readme and the changelog's newest release, whose date the citation has too.

usage: versions.py REPOSITORY
"""

import pathlib
import re
import sys

PLACES = {
    "CMakeLists.txt": r"project\(palpate VERSION (\S+)",
    "pyproject.toml": r'(?m)^version = "([^"]+)"',
    "ros2/palpate_ros2/package.xml": r"<version>([^<]+)</version>",
    "Dockerfile": r"palpate_([^_]+)_amd64\.deb",
    "CITATION.cff": r"(?m)^version: (\S+)",
    "README.md": r"version = \{([^}]+)\}",
    "docs/images/badge-version.svg": r"version: (\d+\.\d+\.\d+)",
    "CHANGELOG.md": r"(?m)^## \[(\d[^\]]*)\] - \d{4}-\d\d-\d\d$",
}
DATES = {
    "CITATION.cff": r"(?m)^date-released: (\S+)",
    "CHANGELOG.md": r"(?m)^## \[\d[^\]]*\] - (\S+)$",
}


def found(root, places):
    """What each file has there, or what to say of it."""
    values = {}
    for name, pattern in places.items():
        match = re.search(pattern, (root / name).read_text())
        values[name] = match.group(1) if match else "nothing"
    return values


def main(root):
    faults = 0
    for what, places in (("version", PLACES), ("date of the release", DATES)):
        values = found(pathlib.Path(root), places)
        if len(set(values.values())) == 1 and "nothing" not in values.values():
            continue
        faults += 1
        print(f"the {what} differs:", ", ".join(f"{k} has {v}" for k, v in values.items()))
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
