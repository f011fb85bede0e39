# SPDX-License-Identifier: Apache-2.0
"""Checks that every number in README.md's tables and headline figures is in the results of the
present program, docs/results without what was tried before.

usage: readme_figures.py REPOSITORY
"""

import pathlib
import re
import sys

HEADLINE = re.compile(r"<!-- begin: headline figures -->(.*?)<!-- end: headline figures -->", re.DOTALL)
NUMBER = re.compile(r"(?<![\w.])\d+(?:\.\d+)?(?:e-?\d+)?(?![\w.]*\d)")


def numbers(text):
    """Numbers of a text, with thousands joined: 69 792 is 69792."""
    return set(NUMBER.findall(re.sub(r"(?<=\d) (?=\d{3}\b)", "", text)))


def claims(readme):
    """The parts of the readme that state measurements: its tables and the headline figures."""
    tables = [line for line in readme.splitlines() if line.startswith("|") and "](" not in line]
    headline = HEADLINE.search(readme)
    if not headline or not any(numbers(line) for line in tables):
        sys.exit("README.md has no headline figures between their comments, or no table of figures")
    return [*tables, *headline.group(1).splitlines()]


def measured(repository):
    pages = [repository / "docs" / "results.md", *(repository / "docs" / "results").glob("*.md")]
    return numbers("\n".join(page.read_text() for page in pages))


def main(repository):
    repository = pathlib.Path(repository)
    known = measured(repository)
    readme = (repository / "README.md").read_text()
    faults = [f"README.md: {number} is not in docs/results: {line.strip()[:90]}"
              for line in claims(readme)
              for number in sorted(numbers(re.sub(r"\]\([^)]*\)", "]", line)) - known)]  # fmt: skip
    print("\n".join(faults) if faults else "every figure of README.md was measured")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
