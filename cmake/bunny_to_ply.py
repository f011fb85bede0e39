# SPDX-License-Identifier: Apache-2.0
"""Writes the Stanford bunny of the npm package `bunny` as an ascii PLY, z up and 80 mm high."""

import json
import os
import re
import sys

HEIGHT = 0.080  # m


def read_array(text, name):
    body = re.search(rf"exports\.{name}\s*=\s*(\[.*?\]\s*\])", text, re.DOTALL).group(1)
    return json.loads(re.sub(r",\s*\]", "]", body))


def main(source, target):
    text = open(source).read()
    points = [(x, -z, y) for x, y, z in read_array(text, "positions")]
    cells = read_array(text, "cells")
    low = [min(p[k] for p in points) for k in range(3)]
    high = [max(p[k] for p in points) for k in range(3)]
    scale = HEIGHT / (high[2] - low[2])
    centre = [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, low[2]]
    with open(target + ".partial", "w") as out:
        out.write(f"ply\nformat ascii 1.0\nelement vertex {len(points)}\n")
        out.write("property float x\nproperty float y\nproperty float z\n")
        out.write(f"element face {len(cells)}\nproperty list uchar int vertex_indices\nend_header\n")
        for p in points:
            out.write(" ".join(f"{(p[k] - centre[k]) * scale:.7f}" for k in range(3)) + "\n")
        for cell in cells:
            out.write("3 " + " ".join(map(str, cell)) + "\n")
    os.rename(target + ".partial", target)


if __name__ == "__main__":
    main(*sys.argv[1:])
