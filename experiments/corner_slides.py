# SPDX-License-Identifier: Apache-2.0
"""Contact normals of fingertips that slide over a rounded corner, as `palpate sense` estimates them.

An independent generator, in no line shared with tests/tactile/sliding.hpp: straight strokes at
20 mm/s between random points of three faces, each over the edge between its two faces, which is
rounded to 1 mm; 100 Hz, 2 N +- 30 %, friction 0.5, force noise 0.05 N, point noise 0.1 mm, tip
normals off by 1 mm on a tip of 7 mm. Estimates from 1 s on. A consistent covariance has a
normalised error squared of 2 and a coverage of 0.95.

usage: corner_slides.py PALPATE [FIRST_SEED [SLIDES [POINT_NOISE_MM]]]
"""

import csv
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

ROUNDING = 1e-3  # m
NEAR, FAR = 2e-3, 14e-3  # m, of the strokes' ends from the corner
SPEED, PERIOD, TIME = 0.02, 0.01, 10.0  # m/s, s, s
SETTLED = 1.0  # s
CHI2_95 = 5.991
ON_ROUNDING = 0.999  # largest component of the normal, below which it is on an edge or the corner


def on_rounded_corner(sharp):
    """Points and outward normals of the corner x, y, z <= 0, shrunk by the rounding and grown again."""
    core = np.minimum(sharp, -ROUNDING)
    n = sharp - core
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    return core + ROUNDING * n, n


def corner_points(random):
    """Ends of the strokes on the sharp corner's faces, with the points where edges are crossed."""
    face, points, length = None, [], 0.0
    while length < 1.5 * SPEED * TIME:
        following = random.integers(3)
        end = -random.uniform(NEAR, FAR, 3)
        end[following] = 0
        if face is not None and following != face:
            edge = np.zeros(3)
            along = 3 - face - following
            edge[along] = points[-1][along] + random.uniform(0.3, 0.7) * (end[along] - points[-1][along])
            points.append(edge)
        points.append(end)
        face = following
        length = sum(np.linalg.norm(b - a) for a, b in zip(points, points[1:]))
    return points


def slide(random, point_noise):
    """Times, noisy points, forces, tip normals, and the true normals."""
    points = corner_points(random)
    sharp = np.concatenate([np.linspace(a, b, 4000, endpoint=False) for a, b in zip(points, points[1:])])
    p, n = on_rounded_corner(sharp)
    way = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(p, axis=0), axis=1))])
    t = np.arange(0, TIME, PERIOD)
    chosen = np.searchsorted(way, SPEED * t)
    p, n = p[chosen], n[chosen]
    along = np.gradient(p, axis=0)
    along -= np.sum(along * n, axis=1, keepdims=True) * n
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)
    press = 2 * (1 + 0.3 * np.sin(2 * np.pi * 0.7 * t + random.uniform(0, 6)))
    f = press[:, None] * (0.5 * along - n) + 0.05 * random.standard_normal(n.shape)
    tip = n + random.standard_normal(n.shape) / 7
    tip /= np.linalg.norm(tip, axis=1, keepdims=True)
    return t, p + point_noise * random.standard_normal(p.shape), f, n, tip


def write_csv(path, samples, with_tip):
    t, p, f, n, tip = samples
    columns = [p, f, n] + ([tip] if with_tip else [])
    header = "finger,t,px,py,pz,fx,fy,fz,nx,ny,nz" + (",tnx,tny,tnz" if with_tip else "")
    rows = [f"FF,{time:.2f}," + ",".join(f"{x:.9g}" for x in row) for time, row in zip(t, np.hstack(columns))]
    path.write_text("\n".join([header, *rows]) + "\n")


def sensed(program, folder, samples, estimator, with_tip):
    """Errors and standard deviations, deg, and whether the contact was on the rounding."""
    write_csv(folder / "slide.csv", samples, with_tip)
    subprocess.run(
        [program, "sense", folder / "slide.csv", "--estimator", estimator, "--out", folder / "out", "--force", "--json"],
        check=True, capture_output=True,
    )  # fmt: skip
    rows = list(csv.DictReader((folder / "out" / "FF.csv").open()))
    rows = [row for row in rows if float(row["t"]) >= SETTLED and np.isfinite(float(row["error_deg"]))]
    ticks = [round(float(row["t"]) / PERIOD) for row in rows]
    error, sigma = (np.array([float(row[name]) for row in rows]) for name in ("error_deg", "sigma_deg"))
    return error, sigma, np.abs(samples[3][ticks]).max(axis=1) < ON_ROUNDING


def figures(error, sigma):
    square = (error / sigma) ** 2
    return (
        f"{len(error):6d}  {np.median(error):5.2f} / {np.quantile(error, 0.95):5.1f} deg  "
        f"{square.mean():5.2f}  {np.mean(square < CHI2_95):.3f}"
    )


def main():
    program = sys.argv[1]
    first, count = (int(x) for x in (*sys.argv[2:4], *("9000", "20")[len(sys.argv[2:4]):]))
    point_noise = float(sys.argv[4]) * 1e-3 if len(sys.argv) > 4 else 1e-4
    slides = [slide(np.random.default_rng(seed), point_noise) for seed in range(first, first + count)]
    print("estimator  tip normals  where  samples, median / p95, normalised error squared, coverage of 95 %")
    with tempfile.TemporaryDirectory() as name:
        for estimator in ("s2", "s2-lag"):
            for with_tip in (True, False):
                parts = [sensed(program, Path(name), s, estimator, with_tip) for s in slides]
                error, sigma, edge = (np.concatenate(part) for part in zip(*parts))
                for where, mask in (("all", edge | True), ("faces", ~edge), ("rounding", edge)):
                    print(f"{estimator:8s} {'yes' if with_tip else 'no':4s} {where:9s}", figures(error[mask], sigma[mask]))


if __name__ == "__main__":
    main()
