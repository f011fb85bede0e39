# SPDX-License-Identifier: Apache-2.0
"""The made-up data of the tests is what its script makes.

usage: made_up_data.py FOLDER
"""

import pathlib
import subprocess
import sys
import tempfile


def main(folder):
    with tempfile.TemporaryDirectory() as made:
        subprocess.run([sys.executable, folder / "make.py", made], check=True)
        expected = {file.name: file.read_bytes() for file in pathlib.Path(made).iterdir()}
    found = {file.name: file.read_bytes() for file in folder.iterdir() if file.suffix != ".py"}
    differing = [name for name in expected | found if expected.get(name) != found.get(name)]
    if differing:
        sys.exit(f"not what tests/data/make.py makes: {', '.join(sorted(differing))}; run it again")


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]))
