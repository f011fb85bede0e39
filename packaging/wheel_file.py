# SPDX-License-Identifier: Apache-2.0
"""Wheels made of files: their metadata, and the record of their hashes."""

import base64
import hashlib
import pathlib
import re
import zipfile

ROOT = pathlib.Path(__file__).resolve().parent.parent


def version():
    text = (ROOT / "pyproject.toml").read_text()
    return re.search(r'^version = "(.*)"$', text, re.MULTILINE).group(1)


def digest(data):
    return base64.urlsafe_b64encode(hashlib.sha256(data).digest()).decode().rstrip("=")


def metadata(name, summary, licence, requirements):
    lines = [
        "Metadata-Version: 2.4",
        f"Name: {name}",
        f"Version: {version()}",
        f"Summary: {summary}",
        f"License-Expression: {licence}",
        "Requires-Python: >=3.11",
        *[f"Requires-Dist: {one}" for one in requirements],
    ]
    return "\n".join(lines) + "\n"


def write_wheel(folder, name, tag, files, summary, licence="Apache-2.0", requirements=()):
    """Writes a wheel of these contents by their paths in it; returns its path.

    The same contents give the same bytes.
    """
    stem = f"{name.replace('-', '_')}-{version()}"
    information = f"{stem}.dist-info"
    pure = str(tag.endswith("-any")).lower()
    text = f"Wheel-Version: 1.0\nGenerator: palpate\nRoot-Is-Purelib: {pure}\nTag: {tag}\n"
    files = {
        **files,
        f"{information}/METADATA": metadata(name, summary, licence, requirements).encode(),
        f"{information}/WHEEL": text.encode(),
        f"{information}/licenses/LICENSE": (ROOT / "LICENSE").read_bytes(),
    }
    record = f"{information}/RECORD"
    rows = [f"{path},sha256={digest(data)},{len(data)}" for path, data in files.items()]
    files[record] = "\n".join([*rows, f"{record},,"]).encode() + b"\n"
    folder.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(folder / f"{stem}-{tag}.whl", "w") as wheel:
        for path, data in files.items():
            wheel.writestr(zipfile.ZipInfo(path, (2026, 1, 1, 0, 0, 0)), data, zipfile.ZIP_DEFLATED)
    return folder / f"{stem}-{tag}.whl"
