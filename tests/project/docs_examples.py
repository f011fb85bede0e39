# SPDX-License-Identifier: Apache-2.0
"""Runs the commands that *.md and docs/*.md show, and checks that links and experiments exist.

usage: docs_examples.py REPOSITORY PALPATE

Of the fenced ```console and ```sh blocks, every line that begins with `palpate ` or `./dev palpate `
(after an optional `$ `) is run. All lines of one file share a temporary folder, in order, so that a
line may use what an earlier one wrote; the repository's examples/ and configs/ are there too. Of a
line that ends in `# long`, and of the pages of results, only the help of its command is run.

A ```cpp block of CONTRIBUTING.md must be an excerpt of a file in examples/extend, whose tests run.
"""

import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile

LONG = re.compile(r"\s+# long\s*$")
COMMAND = re.compile(r"^(?:\$ )?(?:\./dev )?palpate (.*)$")
EXPERIMENT = re.compile(r"^(?:\$ )?\./dev experiment ([\w-]+)", re.MULTILINE)
FENCE = re.compile(r"^```(?:console|sh)\n(.*?)^```", re.MULTILINE | re.DOTALL)
ANY_FENCE = re.compile(r"^```.*?^```", re.MULTILINE | re.DOTALL)
EXCERPT = re.compile(r"^```cpp\n(.*?)^```", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\]\(([^)\s]+)\)")
NO_SOLUTION = 4  # exit code of a pick that fails


def command_lines(text):
    """Commands of a document, as (arguments, whether it takes long)."""
    for block in FENCE.findall(text):
        for line in block.replace("\\\n", " ").splitlines():
            if match := COMMAND.match(LONG.sub("", line)):
                yield shlex.split(match.group(1), comments=True), bool(LONG.search(line))


def fault_of_command(program, arguments, is_long, folder):
    """What is wrong with a command, or None."""
    if is_long:
        arguments = [arguments[0], "--help"]
    allowed = {0, NO_SOLUTION} if arguments[0] == "pick" else {0}
    done = subprocess.run([program, *arguments], cwd=folder, capture_output=True, text=True)
    if done.returncode in allowed:
        return None
    return f"palpate {shlex.join(arguments)}: exit code {done.returncode}: {done.stderr.strip()}"


def faults_of_experiments(text, repository):
    for name in EXPERIMENT.findall(text):
        if not (repository / "experiments" / f"{name}.cpp").exists():
            yield f"no such experiment: {name}"


def faults_of_merges(text):
    """Marks of a merge that nobody has finished."""
    yield from re.findall(r"^(?:<{7}|>{7}) .*$", text, re.MULTILINE)


def faults_of_links(document, text):
    for target in LINK.findall(ANY_FENCE.sub("", text)):
        path = target.split("#")[0]
        if path and ":" not in path and not (document.parent / path).exists():
            yield f"no such file: {target}"


def lines_of(text):
    """A program's lines without their indentation, as one text."""
    return "\n".join(line.strip() for line in text.strip().splitlines()) + "\n"


def faults_of_excerpts(text, repository):
    sources = [lines_of(file.read_text()) for file in (repository / "examples/extend").glob("*.?pp")]
    for excerpt in EXCERPT.findall(text):
        if not any(lines_of(excerpt) in source for source in sources):
            yield f"no file of examples/extend contains: {excerpt.strip().splitlines()[0]}"


def faults_of(document, repository, program):
    text = document.read_text()
    yield from faults_of_merges(text)
    yield from faults_of_links(document, text)
    yield from faults_of_experiments(text, repository)
    if document.name == "CONTRIBUTING.md":
        yield from faults_of_excerpts(text, repository)
    is_result = "results" in (*document.parts, document.stem)
    with tempfile.TemporaryDirectory() as folder:
        for name in ("examples", "configs"):
            if (repository / name).exists():
                shutil.copytree(repository / name, pathlib.Path(folder) / name)
        for arguments, is_long in command_lines(text):
            if fault := fault_of_command(program, arguments, is_long or is_result, folder):
                yield fault


def main(repository, program):
    repository = pathlib.Path(repository)
    documents = [*sorted(repository.glob("*.md")), *sorted((repository / "docs").rglob("*.md"))]
    faults = [
        f"{document.relative_to(repository)}: {fault}"
        for document in documents
        for fault in faults_of(document, repository, program)
    ]
    print("\n".join(faults) if faults else f"{len(documents)} documents hold")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
