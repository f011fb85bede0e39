# SPDX-License-Identifier: Apache-2.0
"""The wheel palpate-sim: what `pip install palpate[sim]` adds, from the modules of a build.

usage: sim_wheel.py MODULES ASSETS OUT    MODULES: the folder palpate of a build's python/

It lies in the package `palpate` beside the base wheel's modules, finds MuJoCo and CoACD in their
own wheels, and brings the models of the Shadow and Adroit hands. auditwheel repairs it afterwards.
"""

import base64
import hashlib
import pathlib
import re
import subprocess
import sys
import zipfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
RPATH = "$ORIGIN/../mujoco:$ORIGIN/../coacd"
LEFT_OUT = {".png", ".html", ".js", ".ply"}  # of the assets: pictures, the viewer, test data


def version():
    text = (ROOT / "pyproject.toml").read_text()
    return re.search(r'^version = "(.*)"$', text, re.MULTILINE).group(1)


def requirements():
    """MuJoCo and CoACD in exactly the versions that the module is linked with."""
    text = (ROOT / "requirements" / "simulation.txt").read_text()
    return re.findall(r"^((?:mujoco|coacd)==\S+)", text, re.MULTILINE)


def metadata():
    lines = [
        "Metadata-Version: 2.4",
        "Name: palpate-sim",
        f"Version: {version()}",
        "Summary: The simulator, picks and their evaluation, of the package palpate",
        "License-Expression: Apache-2.0",
        "Requires-Python: >=3.11",
        f"Requires-Dist: palpate=={version()}",
        *[f"Requires-Dist: {one}" for one in requirements()],
    ]
    return "\n".join(lines) + "\n"


def tag(module):
    """Of the extension module's name: cp311-cp311, or cp312-abi3 for the stable ABI."""
    if ".abi3." in module.name:
        return "cp312-abi3-linux_x86_64"
    python = re.search(r"cpython-(\d+)", module.name).group(1)
    return f"cp{python}-cp{python}-linux_x86_64"


def contents(modules, assets):
    """Names in the wheel and what is in them."""
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
    information = f"palpate_sim-{version()}.dist-info"
    wheel = f"Wheel-Version: 1.0\nGenerator: sim_wheel\nRoot-Is-Purelib: false\nTag: {tag(module)}\n"
    files[f"{information}/METADATA"] = metadata().encode()
    files[f"{information}/WHEEL"] = wheel.encode()
    files[f"{information}/licenses/LICENSE"] = (ROOT / "LICENSE").read_bytes()
    rows = [
        f"{name},sha256={base64.urlsafe_b64encode(hashlib.sha256(data).digest()).decode().rstrip('=')},{len(data)}"
        for name, data in files.items()
    ]
    record = f"{information}/RECORD"
    files[record] = "\n".join([*rows, f"{record},,"]).encode() + b"\n"
    return files, f"palpate_sim-{version()}-{tag(module)}.whl"


def main():
    modules, assets, out = map(pathlib.Path, sys.argv[1:])
    out.mkdir(parents=True, exist_ok=True)
    files, name = contents(modules, assets)
    with zipfile.ZipFile(out / name, "w", zipfile.ZIP_DEFLATED) as wheel:
        for path, data in files.items():
            wheel.writestr(zipfile.ZipInfo(path, (2026, 1, 1, 0, 0, 0)), data, zipfile.ZIP_DEFLATED)
    print(out / name)


if __name__ == "__main__":
    main()
