# SPDX-License-Identifier: Apache-2.0
"""Checks that every figure that README.md states is on the page of results that it links to there.

The sections of FIGURES are read: each row of a table, item of a list and paragraph links to one or
more pages of docs/results, or to sections of them (page.md#section), and each number in it is on one
of these. What was tried before (docs/results/tried) does not count.

usage: readme_figures.py REPOSITORY
"""

import pathlib
import re
import sys

FIGURES = ("Quick start", "What it does", "Compared with other programs", "What it cannot do")
HEADLINE = ("<!-- begin: headline figures -->", "<!-- end: headline figures -->")
NUMBER = re.compile(r"(?<![\w.])\d+(?:\.\d+)?(?:e-?\d+)?(?![\w.]*\d)")
LINK = re.compile(r"\]\(([^)\s]+)\)")
FENCE = re.compile(r"^```.*?^```", re.MULTILINE | re.DOTALL)
NAME = re.compile(r"\b(?:Debian|Python|C\+\+) ?\d[\d.]*")  # no measurements
PART = re.compile(r"\n\n|\n(?=[-|])")
HEADING = re.compile(r"^(#+) (.*)$", re.MULTILINE)


def numbers(text):
    """Numbers of a text, with thousands joined: 69 792 is 69792."""
    return set(NUMBER.findall(re.sub(r"(?<=\d) (?=\d{3}\b)", "", text)))


def anchor(heading):
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


def section(text, name):
    """The text below a heading, to the next of its level; None without that heading."""
    text = FENCE.sub(lambda block: re.sub("(?m)^#", " #", block.group()), text)
    for match in HEADING.finditer(text):
        if name in (match.group(2), anchor(match.group(2))):
            end = re.search(rf"(?m)^#{{1,{len(match.group(1))}}} ", text[match.end() :])
            return text[match.end() :][: end.start() if end else None]
    return None


def results_of(link, root):
    """The text that a link leads to if it is one to the results, else nothing."""
    path, _, name = link.partition("#")
    page = root / path
    is_result = path == "docs/results.md" or (page.parent == root / "docs" / "results")
    if not is_result or not page.exists():
        return ""
    return (section(page.read_text(), name) or "") if name else page.read_text()


def parts(text):
    """Table rows, items and paragraphs without code blocks."""
    return [part.strip() for part in PART.split(FENCE.sub("", text)) if part.strip()]


def faults_of(part, root):
    claimed = numbers(NAME.sub("", LINK.sub("]", part)))
    links = LINK.findall(part)
    known = numbers("\n".join(results_of(link, root) for link in links))
    for number in sorted(claimed - known):
        yield f"README.md: {number} is not in {' '.join(links) or 'any linked results'}: {part[:90]}"


def claims(readme):
    """The parts of the readme that state measurements."""
    for name in FIGURES:
        text = section(readme, name)
        if text is None:
            sys.exit(f"README.md has no section {name}")
        begin, end = (text.find(mark) for mark in HEADLINE)
        if name == "What it does":  # of which only the headline figures are measurements
            if not 0 <= begin < end:
                sys.exit("README.md has no headline figures between their comments")
            text = text[begin + len(HEADLINE[0]) : end]
        yield from parts(text)


def main(repository):
    root = pathlib.Path(repository)
    stated = [part for part in claims((root / "README.md").read_text()) if numbers(part)]
    faults = [fault for part in stated for fault in faults_of(part, root)]
    print("\n".join(faults) if faults else f"{len(stated)} statements of README.md were measured")
    return 1 if faults or not stated else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
