# SPDX-License-Identifier: Apache-2.0
"""What the last run of ctest skipped, and why: a test passes although it skips some of its checks.

usage: skipped.py BUILD/Testing/Temporary/LastTest.log
"""

import ast
import collections
import pathlib
import re
import sys

TEST = re.compile(r"^\d+/\d+ Testing: (.*)$")
PYTHON = re.compile(r"skipped ('.*'|\".*\")$")  # of unittest -v
GOOGLETEST = re.compile(r"^\S+:\d+: Skipped$")  # the reason is on the next line
SCRIPT = re.compile(r"^skipped: (.*)$")


def skips(log):
    """(test, reason) of each check that was skipped, in the order of the log."""
    test, lines = "", iter(log.splitlines())
    for line in lines:
        if match := TEST.match(line):
            test = match[1]
        elif match := PYTHON.search(line):
            yield test, ast.literal_eval(match[1])
        elif GOOGLETEST.match(line):
            yield test, next(lines, "").strip() or "no reason given"
        elif match := SCRIPT.match(line):
            yield test, match[1]


def summary(log):
    counts = collections.Counter(skips(log))
    if not counts:
        return "no check was skipped"
    total = sum(counts.values())
    lines = [f"{total} check{'s were' if total > 1 else ' was'} skipped:"]
    lines += [f"  {test}: {reason}" + (f" ({count} checks)" if count > 1 else "")
              for (test, reason), count in counts.items()]  # fmt: skip
    return "\n".join(lines)


def main(path):
    path = pathlib.Path(path)
    if path.exists():
        print(summary(path.read_text(errors="replace")))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
