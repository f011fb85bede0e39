# SPDX-License-Identifier: Apache-2.0
"""Installs the wheels palpate and palpate-sim into a fresh environment and picks with them.

usage: try_sim_wheel.py PYTHON BASE_WHEEL SIM_WHEEL

Nothing of the checkout is on the path, no compiler either; MuJoCo, CoACD and numpy come from the
package index, in the versions that the wheels ask for.
"""

import pathlib
import subprocess
import sys
import tempfile

TRIED = """
import pathlib, palpate
from palpate import sim
assert "site-packages" in palpate.__file__, palpate.__file__
quick = {"calibrate.touches": 4, "explore.touches": 2}
result = sim.pick("box", seed=3, options=quick)
assert result.status == "held", result
print(result)
tasks = sim.RelocateTasks(2, threads=2, options={"solver": "fast"})
tasks.step([[0.0] * 30] * 2)
print(tasks, tasks.distances)
"""


def main():
    python, *wheels = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([python, "-m", "venv", folder], check=True)
        own = pathlib.Path(folder) / "bin"
        install = [own / "pip", "install", "-q", "--disable-pip-version-check", *wheels]
        subprocess.run(install, check=True)
        environment = {"PATH": str(own), "HOME": folder}
        subprocess.run([own / "python", "-c", TRIED], check=True, env=environment, cwd=folder)


if __name__ == "__main__":
    main()
