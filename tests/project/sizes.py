# SPDX-License-Identifier: Apache-2.0
"""Checks that files and functions stay small, prints how small they are, and compares that with
what docs/architecture.md says (numbers after "Sizes on", which may be 2 % off).

usage: sizes.py REPOSITORY

Files: none over 400 lines, median at most 100. Functions: 95 of 100 at most 25 lines. Of the other
code (tests, scripts, experiments, Python, viewer) only the longest file is checked.
"""

import pathlib
import re
import statistics
import sys

FOLDERS = ("include", "src", "apps")
OTHERS = ("tests", "experiments", "bench", "examples", "fuzz", "python", "viewer", "packaging",
          "docs/site", "cmake", "requirements")  # fmt: skip
MAX_FILE, MAX_MEDIAN, MAX_FUNCTION = 400, 100, 25
QUOTED_WITHIN = 0.02
NO_CODE = re.compile(
    r'//[^\n]*|/\*.*?\*/|R"\w*\(.*?\)\w*"|"(?:\\.|[^"\\\n])*"|(?<!\w)\'(?:\\.|[^\'\\\n])+\'', re.DOTALL
)
SCOPE = re.compile(r"\b(namespace|class|struct|union|enum)\b(?![^{]*\)\s*(const|override)?\s*$)")
CONTROL = re.compile(r"^\s*(if|for|while|switch|do|else|try|catch)\b")


def without_strings(text):
    """The code with the same lines, and nothing in them that only looks like code."""
    return NO_CODE.sub(lambda match: re.sub(r"[^\n]", " ", match.group()), text)


def functions(text):
    """Lengths of the functions that are no lambdas, from the declaration's first line to the last."""
    code = re.sub(r"^\s*#.*$", "", without_strings(text), flags=re.MULTILINE)
    lengths, scopes, start = [], [], 0
    for at, character in enumerate(code):
        if character not in "{};":
            continue
        if character == "{":
            head = code[start:at]
            outside = all(kind == "scope" for kind, _ in scopes)
            if outside and SCOPE.search(head) and not re.search(r"=\s*$", head):
                scopes.append(("scope", 0))
            elif outside and "(" in head and not CONTROL.match(head) and not is_value(head):
                scopes.append(("function", start + len(head) - len(head.lstrip())))
            else:
                scopes.append(("block", start))
                if outside:
                    continue  # a member's value within a declaration that goes on
        elif character == "}" and scopes:
            kind, begin = scopes.pop()
            if kind == "function":
                lengths.append(code.count("\n", begin, at) + 1)
            if kind == "block" and all(other == "scope" for other, _ in scopes):
                continue
        start = at + 1
    return lengths


def is_value(head):
    """Whether the brace after it begins a value, as in `int x{` or `: member_{`."""
    return bool(re.search(r"(=|,|\w_)\s*$", head)) and not head.rstrip().endswith(")")


def measure(root):
    files = [file for folder in FOLDERS for file in (root / folder).rglob("*.[ch]pp")]
    assert len(files) > 100, f"no sources under {root}"
    lines = {file.relative_to(root): file.read_text().count("\n") for file in files}
    lengths = sorted(length for file in files for length in functions(file.read_text()))
    return lines, lengths


def other_lines(root):
    files = [root / "dev"]
    for folder in OTHERS:
        for pattern in ("*.[ch]pp", "*.py", "*.js", "*.sh", "*.cmake"):
            files += (root / folder).rglob(pattern)
    return {file.relative_to(root): file.read_text().count("\n") for file in files}


def wrong_quotes(root, **figures):
    """The figures that docs/architecture.md quotes otherwise, or not at all."""
    text = (root / "docs" / "architecture.md").read_text()
    for what, value in figures.items():
        quoted = re.search(rf"^Sizes on .*?([\d ]*\d) {what}\b", text, re.MULTILINE)
        count = int(quoted[1].replace(" ", "")) if quoted else 0
        if abs(count - value) > QUOTED_WITHIN * value:
            yield f"docs/architecture.md says {count} {what}: {value}"


def main(root):
    lines, lengths = measure(root)
    median = statistics.median(lines.values())
    p95 = lengths[int(0.95 * len(lengths))]
    print(
        f"{len(lines)} files, {sum(lines.values())} lines, median {median:.0f}, longest "
        f"{max(lines.values())}; {len(lengths)} functions, median {statistics.median(lengths):.0f}, "
        f"95 of 100 at most {p95}, longest {lengths[-1]}"
    )
    every = lines | other_lines(root)
    faults = [f"{file} has {count} lines" for file, count in every.items() if count > MAX_FILE]
    if median > MAX_MEDIAN:
        faults.append(f"the median file has {median} lines")
    if p95 > MAX_FUNCTION:
        faults.append(f"more than 5 of 100 functions have over {MAX_FUNCTION} lines")
    of_libraries = sum(count for file, count in lines.items() if file.parts[0] != "apps")
    faults += wrong_quotes(root, files=len(lines), functions=len(lengths), lines=of_libraries)
    print("\n".join(faults), end="\n" if faults else "")
    return bool(faults)


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1]).resolve()))
