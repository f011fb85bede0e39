# SPDX-License-Identifier: Apache-2.0
"""Tries the Debian packages in a Debian 12 that has neither the clone nor, while it tries, a network.

usage: try_packages.py DEB-FOLDER WORK-FOLDER [MIRROR]     (as root; needs debootstrap)

The lines of the Dockerfile are run in a chroot; then the program picks a box, and a program of
someone else's is built upon find_package(palpate COMPONENTS registration) and run. WORK-FOLDER
keeps the fresh Debian for the next time.
"""

import json
import pathlib
import re
import shlex
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
MIRROR = "http://deb.debian.org/debian"
ENTER = 'mount -t proc proc "$0/proc" && mount --rbind /dev "$0/dev" && exec chroot "$@"'


class Chroot:
    """A Debian in a folder. Mounts, and the lack of a network, are those of a command alone."""

    def __init__(self, folder):
        self.folder, self.user, self.directory = folder, "root", "/"

    def run(self, *words, network=False, capture=False):
        namespaces = ["unshare", "--mount", *([] if network else ["--net"])]
        account = f"--userspec={self.user}"
        home = "/root" if self.user == "root" else f"/home/{self.user}"
        inside = ["env", "-i", f"HOME={home}", "PATH=/usr/sbin:/usr/bin:/sbin:/bin",
                  "DEBIAN_FRONTEND=noninteractive",
                  "sh", "-c", 'cd "$0" && exec "$@"', self.directory, *words]  # fmt: skip
        print("==>", shlex.join(words), file=sys.stderr)
        done = subprocess.run(
            [*namespaces, "sh", "-c", ENTER, self.folder, account, self.folder, *inside],
            stdout=subprocess.PIPE if capture else sys.stderr, text=True)  # fmt: skip
        if done.returncode:
            sys.exit(f"exit code {done.returncode} of: {shlex.join(words)}")
        return done.stdout

    def copy(self, source, target):
        target = self.folder / target.lstrip("/")
        target.parent.mkdir(parents=True, exist_ok=True)
        copy = shutil.copytree if source.is_dir() else shutil.copyfile
        copy(source, target)


def fresh_debian(work, mirror):
    """A chroot of its own, from a Debian that is fetched once."""
    base, root, fetched = work / "base", work / "root", work / "fetched"
    if not fetched.exists():
        shutil.rmtree(base, ignore_errors=True)
        work.mkdir(parents=True, exist_ok=True)
        subprocess.run(["debootstrap", "--variant=minbase", "bookworm", base, mirror],
                       check=True, stdout=sys.stderr)  # fmt: skip
        fetched.touch()
    shutil.rmtree(root, ignore_errors=True)
    subprocess.run(["cp", "-a", "--reflink=auto", base, root], check=True)
    shutil.copyfile("/etc/resolv.conf", root / "etc/resolv.conf")
    return Chroot(root)


def instructions(dockerfile):
    """(word, rest) of every instruction of a Dockerfile, its continued lines joined."""
    text = re.sub(r"^#.*\n", "", dockerfile.read_text(), flags=re.MULTILINE)
    for line in filter(None, text.replace("\\\n", " ").splitlines()):
        yield line.split(maxsplit=1)


def build_image(chroot, dockerfile, debs):
    """Runs the lines of a Dockerfile; the command that its container runs."""
    entry, arguments = [], []
    for word, rest in instructions(dockerfile):
        if word == "FROM":
            assert rest == "debian:bookworm-slim", rest
        elif word == "COPY":
            source, target = rest.split()
            assert source.startswith("build/deb/"), source
            chroot.copy(debs / pathlib.Path(source).name, target)
        elif word == "RUN":
            chroot.run("sh", "-c", rest, network=True)
        elif word == "USER":
            chroot.user = rest
        elif word == "WORKDIR":
            chroot.directory = rest
        elif word == "ENTRYPOINT":
            entry = json.loads(rest)
        elif word == "CMD":
            arguments = json.loads(rest)
        else:
            sys.exit(f"{dockerfile}: {word} is not understood here")
    return entry, arguments


def try_program(chroot, entry, arguments):
    chroot.run(*entry, *arguments)
    picked = json.loads(chroot.run(*entry, "pick", "--object", "box", "--seed", "3", "--json",
                                   "--quiet", capture=True))  # fmt: skip
    assert picked["lifted"] and picked["estimate"]["rotation_error_deg"] < 5, picked["estimate"]
    print(f"pick: lifted, {picked['estimate']['rotation_error_deg']:.1f} deg, "
          f"{picked['estimate']['translation_error_mm']:.1f} mm off")  # fmt: skip


def try_libraries(chroot, debs):
    """Someone else's program on one component, which must not ask for the simulator."""
    chroot.user, chroot.directory = "root", "/"
    for deb in debs.glob("*.deb"):
        chroot.copy(deb, f"/tmp/debs/{deb.name}")
    chroot.copy(ROOT / "tests/project/component", "/tmp/component")
    chroot.run("sh", "-c", "apt-get update && apt-get install -y --no-install-recommends g++ cmake "
               "make /tmp/debs/*.deb", network=True)  # fmt: skip
    chroot.run("cmake", "-S", "/tmp/component", "-B", "/tmp/built", "-DCOMPONENT=registration")
    chroot.run("cmake", "--build", "/tmp/built")
    chroot.run("/tmp/built/component")
    chroot.run("test", "-f", "/usr/share/palpate_ros2/package.xml")
    print("find_package(palpate COMPONENTS registration): built and run")


def main(debs, work, mirror=MIRROR):
    debs = pathlib.Path(debs).resolve()
    chroot = fresh_debian(pathlib.Path(work).resolve(), mirror)
    entry, arguments = build_image(chroot, ROOT / "Dockerfile", debs)
    try_program(chroot, entry, arguments)
    try_libraries(chroot, debs)


if __name__ == "__main__":
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    main(*sys.argv[1:])
