# SPDX-License-Identifier: Apache-2.0
"""What Palpate is built on: installed files that stay what they were, and a bill of materials.

usage: dependencies.py note NAME DEPS FROM-FILE FOLDER...   note the hash of all files in the folders
       dependencies.py check NAME DEPS                      exit code 0 if all is as it was noted
       dependencies.py choose REQUIREMENTS PACKAGE...       their lines of the file, with hashes
       dependencies.py pin WHEEL                            a line that pip installs the file by
       dependencies.py sbom                                 CycloneDX 1.5 JSON on stdout
"""

import hashlib
import json
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
LICENCES = ROOT / "docs" / "licences.md"


def hash_of_file(path):
    digest = hashlib.sha256()
    with open(path, "rb") as file:
        for block in iter(lambda: file.read(1 << 20), b""):
            digest.update(block)
    return digest.hexdigest()


def hash_of_tree(folders, content_of):
    """One hash of the names of all files and of what content_of tells of each."""
    digest = hashlib.sha256()
    for folder in folders:
        for path in sorted(folder.rglob("*")):
            if "__pycache__" in path.parts or (path.is_dir() and not path.is_symlink()):
                continue
            digest.update(f"{path.relative_to(folder)}\0{content_of(path)}\n".encode())
    return digest.hexdigest()


def content(path):
    return path.readlink() if path.is_symlink() else hash_of_file(path)


def times(path):
    """Changes whenever the file does; much quicker to tell than its content."""
    status = path.lstat()
    return (status.st_size, status.st_mtime_ns, status.st_ctime_ns)


def stamp_of(name, deps):
    return pathlib.Path(deps) / f"{name}.json"


def note(name, deps, source, *folders):
    paths = [pathlib.Path(deps) / folder for folder in folders]
    stamp = {
        "source": source,
        "source_sha256": hash_of_file(ROOT / source),
        "folders": folders,
        "sha256": hash_of_tree(paths, content),
        "times": hash_of_tree(paths, times),
    }
    stamp_of(name, deps).write_text(json.dumps(stamp, indent=2) + "\n")


def check(name, deps):
    """Whether what was noted is there, unaltered, and its source is still the one asked for."""
    try:
        stamp = json.loads(stamp_of(name, deps).read_text())
        folders = [pathlib.Path(deps) / folder for folder in stamp["folders"]]
        wanted = stamp["source_sha256"] == hash_of_file(ROOT / stamp["source"])
        untouched = stamp["times"] == hash_of_tree(folders, times)
        intact = untouched or stamp["sha256"] == hash_of_tree(folders, content)
    except (OSError, ValueError, KeyError):
        return False
    if wanted and intact and not untouched:
        note(name, deps, stamp["source"], *stamp["folders"])
    if wanted and not intact:
        print(f"dev: {deps}: what {stamp['source']} installed was altered", file=sys.stderr)
    return wanted and intact


def choose(requirements, *packages):
    """The lines of some packages of a requirements file. Raises KeyError for one that it lacks."""
    text = (ROOT / requirements).read_text().replace("\\\n", " ")
    lines = dict(re.findall(r"^([\w.-]+)(==.*)$", text, re.MULTILINE))
    for package in packages:
        print(package + lines[package])


def pin(wheel):
    path = pathlib.Path(wheel).resolve()
    name = path.name.split("-")[0].replace("_", "-")
    print(f"{name} @ {path.as_uri()} --hash=sha256:{hash_of_file(path)}")


def python_components():
    for requirements in sorted((ROOT / "requirements").glob("*.txt")):
        text = requirements.read_text().replace("\\\n", " ")
        for name, version, rest in re.findall(r"^([\w.-]+)==(\S+)(.*)$", text, re.MULTILINE):
            hashes = re.findall(r"sha256:([0-9a-f]{64})", rest)
            yield {
                "type": "library", "name": name, "version": version,
                "purl": f"pkg:pypi/{name}@{version}", "scope": scope_of(requirements.stem),
                "hashes": [{"alg": "SHA-256", "content": content} for content in hashes],
            }  # fmt: skip


def scope_of(requirements):
    return "required" if requirements == "simulation" else "optional"


def npm_locks():
    return (ROOT / "requirements").rglob("package-lock.json")


def npm_components():
    packages = [
        (lock.parent.name, path, package)
        for lock in sorted(npm_locks())
        for path, package in json.loads(lock.read_text())["packages"].items()
        if path
    ]
    for folder, path, package in packages:
        name = path.removeprefix("node_modules/")
        yield {
            "type": "library", "name": name, "version": package["version"],
            "purl": f"pkg:npm/{name.replace('@', '%40')}@{package['version']}",
            "scope": "optional" if package.get("optional") or folder == "bunny" else "required",
            "hashes": [{"alg": "SHA-512", "content": sha512_of(package["integrity"])}],
            "licenses": [{"license": {"name": package.get("license", "see docs/licences.md")}}],
        }  # fmt: skip


def sha512_of(integrity):
    import base64

    return base64.b64decode(integrity.removeprefix("sha512-")).hex()


def debian_packages():
    text = (ROOT / "requirements" / "install.sh").read_text()
    return re.search(r"debian_packages=\(([^)]*)\)", text).group(1).split()


def debian_components():
    for name in debian_packages():
        done = subprocess.run(
            ["dpkg-query", "-W", "-f", "${Version}", name], capture_output=True, text=True
        )
        version = done.stdout or "not installed"
        yield {"type": "library", "name": name, "version": version, "scope": "required",
               "purl": f"pkg:deb/debian/{name}@{version}"}  # fmt: skip


def sbom():
    version = re.search(r"project\(palpate VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text())
    print(json.dumps({
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        "version": 1,
        "metadata": {"component": {
            "type": "application", "name": "palpate", "version": version.group(1),
            "licenses": [{"license": {"id": "Apache-2.0"}}]}},
        "components": [*python_components(), *npm_components(), *debian_components()],
    }, indent=2))  # fmt: skip


def main(command, *arguments):
    if command == "note":
        note(*arguments)
    elif command == "check":
        return 0 if check(*arguments) else 1
    elif command == "choose":
        choose(*arguments)
    elif command == "pin":
        pin(*arguments)
    else:
        sbom()
    return 0


if __name__ == "__main__":
    sys.exit(main(*(sys.argv[1:] or ["sbom"])))
