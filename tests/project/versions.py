# SPDX-License-Identifier: Apache-2.0
"""One version everywhere: CMake, the Python and ROS 2 packages, the Dockerfile, the citation, the
readme and the changelog's newest release, whose date the citation has too. As long as that release
has no tag, nothing stands under Unreleased: it would be missing from the release.

usage: versions.py REPOSITORY
"""

import pathlib
import re
import subprocess
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


def git(root, *arguments):
    """What git prints, or nothing where there is no git or no repository."""
    try:
        done = subprocess.run(["git", "-C", root, *arguments], capture_output=True, text=True)
    except FileNotFoundError:
        return ""
    return done.stdout.strip() if done.returncode == 0 else ""


def is_untagged(root, version):
    """False where nobody knows: in a copy without a repository, or a clone without all tags."""
    if git(root, "rev-parse", "--is-shallow-repository") != "false":
        return False
    return not git(root, "tag", "--list", f"v{version}")


def unreleased(root):
    text = (root / "CHANGELOG.md").read_text()
    return re.search(r"(?ms)^## \[Unreleased\]\n(.*?)^## \[", text + "\n## [").group(1).strip()


def main(root):
    root = pathlib.Path(root)
    faults = 0
    for what, places in (("version", PLACES), ("date of the release", DATES)):
        values = found(root, places)
        if len(set(values.values())) == 1 and "nothing" not in values.values():
            continue
        faults += 1
        print(f"the {what} differs:", ", ".join(f"{k} has {v}" for k, v in values.items()))
    version = found(root, PLACES)["CHANGELOG.md"]
    if unreleased(root) and is_untagged(root, version):
        faults += 1
        print(f"CHANGELOG.md has entries under Unreleased, but there is no tag v{version} yet: "
              f"they belong to {version}")  # fmt: skip
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
