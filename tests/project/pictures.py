# SPDX-License-Identifier: Apache-2.0
"""Every picture of the readme and the documentation was made by ./dev pictures and is not older
than the sources that draw it.

usage: pictures.py REPOSITORY

A picture must be named by a page, be of a set of docs/site/pictures.py, and have the hash that was
noted when it was made; only sketches have no note. The hash of the sources that a set follows must
be the noted one as well: after a change of what draws it, `./dev pictures SET` makes the set again.
"""

import json
import pathlib
import re
import struct
import sys

LARGEST = 3 << 20  # bytes of an animation in the readme
CLIP_SECONDS = (11, 13)


def named_pictures(root):
    """File in docs/images: a page that names it."""
    named = {}
    for page in [root / "README.md", *root.glob("docs/**/*.md"), *root.glob("models/*.md")]:
        for link in re.findall(r"\]\(([^)\s]+\.(?:png|svg|gif|webp))\)", page.read_text()):
            path = (page.parent / link).resolve()
            if path.parent == root / "docs" / "images":
                named[path.name] = page.relative_to(root)
    return named


def faults_of_files(root, pictures):
    named = named_pictures(root)
    there = {f.name for f in pictures.IMAGES.iterdir() if f.suffix != ".json"}
    of_sets = {picture for chosen in pictures.SETS.values() for picture in chosen.pictures}
    for picture in sorted(named.keys() - there):
        yield f"{named[picture]}: docs/images/{picture} does not exist"
    for picture in sorted(there - named.keys()):
        yield f"docs/images/{picture}: no page shows it"
    for picture in sorted(there - of_sets - pictures.SKETCHES):
        yield f"docs/images/{picture}: no set of docs/site/pictures.py makes it"


def faults_of_sets(pictures, made):
    for name, chosen in pictures.SETS.items():
        again = f"run ./dev pictures {name}"
        noted = made.get(name)
        if not noted or noted["commands"] != list(chosen.commands):
            yield f"{name}: not made by its present commands; {again}"
            continue
        for picture in chosen.pictures:
            file = pictures.IMAGES / picture
            if file.exists() and pictures.hash_of(file) != noted["pictures"].get(picture):
                yield f"docs/images/{picture}: not what the command made; {again}"
        now = pictures.hash_of_sources(chosen.follows)
        if not now:
            yield f"{name}: follows no sources"
        elif noted["follows"] != now:
            yield f"{name}: older than {' '.join(chosen.follows)}; {again}"


def seconds_of_animation(file):
    """How long an animated PNG plays; 0 for a still one."""
    data, at, seconds = file.read_bytes(), 8, 0.0
    while at + 12 <= len(data):
        size, kind = struct.unpack(">I4s", data[at : at + 8])
        if kind == b"fcTL":
            numerator, denominator = struct.unpack(">HH", data[at + 28 : at + 32])
            seconds += numerator / (denominator or 100)
        at += 12 + size
    return seconds


def faults_of_clip(pictures):
    clip = pictures.IMAGES / "posterior.png"
    if clip.stat().st_size > LARGEST:
        yield f"{clip.name} has {clip.stat().st_size} bytes, of at most {LARGEST}"
    seconds = seconds_of_animation(clip)
    if not CLIP_SECONDS[0] <= seconds <= CLIP_SECONDS[1]:
        yield f"{clip.name} plays {seconds:.1f} s, not {CLIP_SECONDS[0]} to {CLIP_SECONDS[1]} s"


def main(root):
    root = pathlib.Path(root).resolve()
    sys.path.insert(0, str(root / "docs" / "site"))
    sys.dont_write_bytecode = True
    import pictures

    made = json.loads(pictures.MADE.read_text())
    faults = [*faults_of_files(root, pictures), *faults_of_sets(pictures, made),
              *faults_of_clip(pictures)]  # fmt: skip
    print("\n".join(faults) if faults else "the pictures are those that the commands made")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
