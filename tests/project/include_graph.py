# SPDX-License-Identifier: Apache-2.0
"""Checks that every library includes only those to its left, that the folders within a library
include each other in one direction, and MuJoCo only where it belongs.

usage: include_graph.py REPOSITORY
"""

import collections
import pathlib
import re
import sys

LIBRARIES = (
    "core plotting numerics geometry registration hand tactile grasping localization estimation "
    "planning skills recording ros2 bridge learning simulation evaluation tasks"
).split()
FIRST_WITH_SIMULATOR = "simulation"
INCLUDE = re.compile(r'^\s*#include\s+[<"]([^>"]+)[>"]', re.MULTILINE)

# Includes that would close a circle of folders, from a folder (or "*", any) to a header.
LEFT = {
    ("*", "simulation/world/mujoco_handles.hpp"):
        "owners of MuJoCo's C structs, which includes nothing of Palpate and belongs to no folder",
    ("tasks/relocate/policies", "tasks/relocate/training/structured_search.hpp"):
        "the observer of velocities is trained on the rollouts of the search",
}  # fmt: skip


def library_of_header(header):
    """The library of a header, public ("palpate/LIBRARY/...") or private, or None."""
    parts = header.removeprefix("palpate/").split("/")
    return parts[0] if len(parts) > 1 and parts[0] in LIBRARIES else None


def folder_of(path):
    """A library's folder of a file ("simulation/hand"), or, beside its folders, the file itself."""
    parts = path.split("/")
    depth = 3 if parts[0] == "tasks" else 2
    return "/".join(parts[: min(depth, len(parts))])


def sources(root):
    bases = (root / "include" / "palpate", root / "src")
    files = [(base, file) for base in bases for file in sorted(base.rglob("*.[ch]pp"))]
    assert files, f"no sources under {root}"
    for base, file in files:
        yield file.relative_to(base).as_posix(), file


def order_of_libraries(root):
    for name, file in sources(root):
        library = name.split("/")[0]
        if library not in LIBRARIES:
            yield f"{file.relative_to(root)}: {library} is not a library of Palpate"
            continue
        for header in INCLUDE.findall(file.read_text()):
            included = library_of_header(header)
            if included and LIBRARIES.index(included) > LIBRARIES.index(library):
                yield f"{file.relative_to(root)}: {library} may not include {header}"
            early = LIBRARIES.index(library) < LIBRARIES.index(FIRST_WITH_SIMULATOR)
            if header.startswith("mujoco/") and early:
                yield f"{file.relative_to(root)}: {library} may not include {header}"


def folder_graph(root, left):
    """For each folder those that it includes, each with one file that does; `left` out."""
    graph, used = collections.defaultdict(dict), set()
    for name, file in sources(root):
        for header in INCLUDE.findall(file.read_text()):
            if not library_of_header(header):
                continue
            header = header.removeprefix("palpate/")
            folder, included = folder_of(name), folder_of(header)
            if folder == included:
                continue
            exempt = {(folder, header), ("*", header)} & left.keys()
            used |= exempt
            if not exempt:
                graph[folder].setdefault(included, f"{name} includes {header}")
    return graph, used


def circles(graph):
    """One circle of folders after another, each without the include that closed the one before."""
    while circle := first_circle(graph):
        yield [graph[a][b] for a, b in circle]
        a, b = circle[-1]
        del graph[a][b]


def first_circle(graph):
    """The edges of one circle, by depth-first search; None if there is none."""
    done, path = set(), []

    def visit(folder):
        if folder in path:
            ring = path[path.index(folder) :] + [folder]
            return list(zip(ring, ring[1:]))
        if folder in done:
            return None
        path.append(folder)
        for included in sorted(graph.get(folder, ())):
            if found := visit(included):
                return found
        path.pop()
        done.add(folder)
        return None

    for folder in sorted(graph):
        if found := visit(folder):
            return found
    return None


def order_of_folders(root):
    graph, used = folder_graph(root, LEFT)
    for circle in circles(graph):
        yield "a circle of folders:\n  " + "\n  ".join(circle)
    for folder, header in LEFT.keys() - used:
        yield f"{folder} no longer includes {header}: take it off the list"
    for edge in used:
        others = {other: why for other, why in LEFT.items() if other != edge}
        if not first_circle(folder_graph(root, others)[0]):
            yield f"{edge[0]} may include {edge[1]}, which closes no circle: take it off the list"


if __name__ == "__main__":
    root = pathlib.Path(sys.argv[1])
    found = [*order_of_libraries(root), *order_of_folders(root)]
    print("\n".join(found) or "the include graph follows the order of the libraries")
    sys.exit(bool(found))
