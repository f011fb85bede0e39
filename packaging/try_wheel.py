# SPDX-License-Identifier: Apache-2.0
"""Times a first pose by the base wheel on a Debian 12 that has Python and nothing else of use.

usage: try_wheel.py WHEEL WORK-FOLDER [MIRROR]     (as root; needs debootstrap)

WORK-FOLDER keeps the fresh Debian for the next time. Prints JSON: seconds of the environment, of
`pip install` from an empty cache, of the first pose, and of an import.
"""

import json
import pathlib
import statistics
import sys
import time

from try_packages import MIRROR, ROOT, fresh_debian

PIP = ["PIP_CERT=/etc/ssl/certs/ca-certificates.crt", "/try/bin/pip", "install", "-q",
       "--no-cache-dir", "--disable-pip-version-check"]  # fmt: skip
IMPORT = "import time; t = time.perf_counter(); import palpate; print(time.perf_counter() - t)"


def seconds(work):
    begin = time.monotonic()
    work()
    return round(time.monotonic() - begin, 1)


def main():
    wheel, work, mirror = [*map(pathlib.Path, sys.argv[1:3]), *sys.argv[3:], MIRROR][:3]
    debian = fresh_debian(work, mirror)
    debian.run("apt-get", "update", "-qq", network=True)
    debian.run("apt-get", "install", "-y", "-qq", "--no-install-recommends", "python3",
               "python3-venv", "ca-certificates", network=True)  # fmt: skip
    certificates = pathlib.Path("/etc/ssl/certs/ca-certificates.crt")  # the network's own too
    debian.copy(certificates, str(certificates))
    debian.copy(wheel, f"/{wheel.name}")
    debian.copy(ROOT / "examples" / "python" / "localize.py", "/localize.py")
    found = {"wheel": wheel.name, "bytes": wheel.stat().st_size}
    found["environment_s"] = seconds(lambda: debian.run("python3", "-m", "venv", "/try"))
    found["install_s"] = seconds(
        lambda: debian.run("env", *PIP, f"/{wheel.name}", network=True)
    )
    found["first_pose_s"] = seconds(lambda: debian.run("/try/bin/python", "/localize.py"))
    imports = [float(debian.run("/try/bin/python", "-c", IMPORT, capture=True)) for _ in range(5)]
    found["import_s"] = [round(min(imports), 3), round(statistics.median(imports), 3)]
    print(json.dumps(found))


if __name__ == "__main__":
    main()
