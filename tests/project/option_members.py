# SPDX-License-Identifier: Apache-2.0
"""An option's key and the member that it sets have one name: v("max_force", max_force, ...).

usage: option_members.py REPOSITORY
"""

import pathlib
import re
import sys

FOLDERS = ("include", "src", "apps")
LEAST = 700  # options that the pattern must find
OPTION = re.compile(
    r"\bv(?:\.expert|\.section|\.expert_section)?\("
    r'\s*"(?P<key>\w+)",\s*(?:\w+\.)*(?P<member>\w+)\s*[,)]'
)
COMMENT = re.compile(r"//[^\n]*")
OTHERS = {
    # A field of a ROS message; the struct has a function `fields`.
    ("include/palpate/ros2/messages/sensor_msgs.hpp", "fields"): "point_fields",
    # Members of the outlier filter's own options, without a section of their own.
    ("apps/palpate/register.cpp", "filter_neighbours"): "neighbours",
    ("apps/palpate/register.cpp", "filter_deviation_ratio"): "deviation_ratio",
}


def options(text):
    """Key, member's name and line of every option of a source text."""
    code = COMMENT.sub("", text)
    for found in OPTION.finditer(code):
        yield found["key"], found["member"], code.count("\n", 0, found.start()) + 1


def main():
    root = pathlib.Path(sys.argv[1])
    faults, count = [], 0
    for path in sorted(p for folder in FOLDERS for p in (root / folder).rglob("*.[ch]pp")):
        name = path.relative_to(root).as_posix()
        for key, member, line in options(path.read_text()):
            count += 1
            if member != key and OTHERS.get((name, key)) != member:
                faults.append(f"{name}:{line}: option {key} sets the member {member}")
    if count < LEAST:
        faults.append(f"only {count} options found: has their form changed?")
    print("\n".join(faults) or f"{count} options, each of its member's name")
    return bool(faults)


if __name__ == "__main__":
    sys.exit(main())
