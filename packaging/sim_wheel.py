# SPDX-License-Identifier: Apache-2.0
"""The wheel palpate-sim: what `pip install palpate[sim]` adds, from the modules of a build.

usage: sim_wheel.py MODULES ASSETS OUT    MODULES: the folder palpate of a build's python/

It lies in the package `palpate` beside the base wheel's modules, finds MuJoCo and CoACD in their
own wheels, and brings the models of the Shadow and Adroit hands. auditwheel repairs it afterwards.
"""

import pathlib
import re
import subprocess
import sys

from wheel_file import ROOT, version, write_wheel

RPATH = "$ORIGIN/../mujoco:$ORIGIN/../coacd"
LEFT_OUT = {".png", ".html", ".js", ".ply"}  # of the assets: pictures, the viewer, test data


def requirements():
    """MuJoCo and CoACD in exactly the versions that the module is linked with."""
    text = (ROOT / "requirements" / "simulation.txt").read_text()
    return re.findall(r"^((?:mujoco|coacd)==\S+)", text, re.MULTILINE)


def tag(module):
    """Of the extension module's name: cp311-cp311, or cp312-abi3 for the stable ABI."""
    if ".abi3." in module.name:
        return "cp312-abi3-linux_x86_64"
    python = re.search(r"cpython-(\d+)", module.name).group(1)
    return f"cp{python}-cp{python}-linux_x86_64"


def contents(modules, assets):
    """Paths in the wheel and what is in them."""
    (module,) = modules.glob("_sim*.so")
    library = pathlib.Path(sys.argv[3]) / module.name
    library.write_bytes(module.read_bytes())
    subprocess.run(["strip", "--strip-unneeded", library], check=True)
    subprocess.run(["patchelf", "--set-rpath", RPATH, library], check=True)
    files = {f"palpate/{module.name}": library.read_bytes()}
    library.unlink()
    files["palpate/_sim.pyi"] = (modules / "_sim.pyi").read_bytes()
    for path in sorted(assets.rglob("*")):
        if path.is_file() and path.suffix not in LEFT_OUT:
            files[f"palpate/assets/{path.relative_to(assets)}"] = path.read_bytes()
    return files


def main():
    modules, assets, out = map(pathlib.Path, sys.argv[1:])
    out.mkdir(parents=True, exist_ok=True)
    (module,) = modules.glob("_sim*.so")
    wheel = write_wheel(
        out,
        "palpate-sim",
        tag(module),
        contents(modules, assets),
        "The simulator, picks and their evaluation, of the package palpate",
        requirements=[f"palpate=={version()}", *requirements()],
    )
    print(wheel)


if __name__ == "__main__":
    main()
