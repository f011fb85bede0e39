# SPDX-License-Identifier: Apache-2.0
"""Builds the documentation site, which is read without a network.

usage: build.py SPHINX_BUILD PALPATE FOLDER [DOXYGEN]

FOLDER/html/index.html is its first page. The pages are those of the repository, in the same
places, so that a link which works there works here; the reference is made by reference.py.
Warnings are errors: a link or anchor that leads nowhere ends the build with exit code 1.
Without the Python package beside the program (build/*/python) its reference says so.
"""

import pathlib
import re
import shutil
import subprocess
import sys

import reference

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
FOLDERS = ("docs", "models", "examples", "configs")
PAGES = ("CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md", "LICENSE", "CITATION.cff", "Dockerfile")
FRONT_PAGE = re.compile(r"(\]\((?:\.\./)*)README\.md")  # a link to it; on the site it is index.md


def copy_pages(source):
    for folder in FOLDERS:
        ignored = shutil.ignore_patterns("site", "*.model", "*.json", "*.h5", "CMakeLists.txt")
        shutil.copytree(ROOT / folder, source / folder, ignore=ignored)
    for page in PAGES:
        shutil.copy(ROOT / page, source / page)
    (source / "packaging").mkdir()
    shutil.copy(ROOT / "packaging" / "copyright", source / "packaging")
    shutil.copy(ROOT / "README.md", source / "index.md")
    for page in source.rglob("*.md"):
        page.write_text(FRONT_PAGE.sub(r"\1index.md", page.read_text()))


def make_reference(source, program, has_doxygen):
    stubs = pathlib.Path(program).resolve().parent / "../../python/palpate/_core.pyi"
    pages = {
        "commands": reference.commands_page(program),
        "options": reference.options_page(program),
        "python": reference.python_page(stubs.read_text() if stubs.exists() else ""),
        "cpp": reference.cpp_page(has_doxygen),
    }
    (source / "reference").mkdir()
    for name, text in pages.items():
        (source / "reference" / f"{name}.md").write_text(text)


def make_cpp_reference(doxygen, html):
    """The headers' own documentation, below cpp/."""
    settings = (HERE / "Doxyfile").read_text() + f"\nOUTPUT_DIRECTORY = {html}\nHTML_OUTPUT = cpp\n"
    subprocess.run([doxygen, "-"], cwd=ROOT, input=settings, text=True, check=True)


def main(sphinx, program, folder, doxygen=None):
    folder = pathlib.Path(folder).resolve()
    source, html = folder / "source", folder / "html"
    for old in (source, html):
        shutil.rmtree(old, ignore_errors=True)
    source.mkdir(parents=True)
    copy_pages(source)
    make_reference(source, program, bool(doxygen))
    done = subprocess.run(
        [sphinx, "-W", "--keep-going", "-q", "-b", "html", "-c", HERE, "-d", folder / "doctrees",
         source, html]
    )  # fmt: skip
    if done.returncode == 0 and doxygen:
        make_cpp_reference(doxygen, html)
    return done.returncode


if __name__ == "__main__":
    if len(sys.argv) not in (4, 5):
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
