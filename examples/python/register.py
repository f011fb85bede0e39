# SPDX-License-Identifier: Apache-2.0
"""Register two scans whose correspondences are mostly wrong, and read the certificate.

usage: register.py [--figure FILE]
"""

import argparse
import tempfile

import numpy as np

import palpate

arguments = argparse.ArgumentParser()
arguments.add_argument("--figure", help="draw pairs, bound and clouds into this file, with matplotlib")
given = arguments.parse_args()

# 100 pairs of points, 30 of them right: as feature matching of two scans gives them.
random = np.random.default_rng(3)
source = random.uniform(-0.1, 0.1, (100, 3))
angle = np.radians(40)
truth = np.eye(4)
truth[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
truth[:3, 3] = [0.02, -0.05, 0.1]
target = source @ truth[:3, :3].T + truth[:3, 3] + 0.0005 * random.standard_normal((100, 3))
target[30:] = random.uniform(-0.15, 0.15, (70, 3))

# noise_bound: how far off a right pair may be. bound_nodes asks for a bound on any pose's inliers.
result = palpate.register_correspondences(source, target, noise_bound=0.003, bound_nodes=10000)
print(result)

# Three different questions, three answers:
print(f"is there a consensus at all?  {result.false_alarms:.1e} such poses by chance")
print(f"is the pose optimal for its inliers?  {result.certificate.least_squares}")
bound = result.certificate.robust_bound
print(f"could another pose have more inliers?  at most {bound.max_inliers}, this one has "
      f"{len(result.inliers)}")  # fmt: skip

# The same question about anyone's pose: how far above the least can its cost be?
right = result.inliers
print(palpate.certify(result.T_target_source, source[right], target[right]))

# Without correspondences: two clouds of the same object, matched by their features.
with tempfile.TemporaryDirectory() as folder:
    scan = f"{folder}/scan.ply"
    palpate.load_known_object("bracket").mesh.save(scan)
    first, second = palpate.load_cloud(scan, samples=6000), palpate.load_cloud(scan, samples=8000)
moved = palpate.PointCloud(second.points @ truth[:3, :3].T + truth[:3, 3])
clouds = palpate.register_clouds(palpate.PointCloud(first.points), moved)
print(clouds)
print(clouds.result.T_target_source)

# The pairs by how far the pose leaves them apart, the bound on inliers, and the aligned clouds.
if given.figure:
    from matplotlib import pyplot

    figure, (left, middle, last) = pyplot.subplots(1, 3, figsize=(13, 4), layout="constrained")
    T = result.T_target_source
    apart = 1e3 * np.linalg.norm(source @ T[:3, :3].T + T[:3, 3] - target, axis=1)
    left.hist(apart, bins=np.geomspace(0.1, 500, 40))
    left.axvline(3, color="tab:red", label="noise bound")
    left.set(xscale="log", xlabel="distance of a pair under the pose, mm", ylabel="pairs",
             title="30 pairs are right, 70 are wrong")  # fmt: skip
    left.legend()
    middle.bar(["this pose", "any pose, at most"], [len(right), bound.max_inliers])
    middle.set(ylabel="inliers", title="no pose has more inliers, which is proven"
               if bound.max_inliers == len(right) else "another pose may have more")  # fmt: skip
    T = clouds.result.T_target_source
    aligned = 1e3 * (first.points @ T[:3, :3].T + T[:3, 3])
    last.plot(*(1e3 * moved.points.T[:2]), ".", markersize=1, label="target")
    last.plot(*aligned.T[:2], ".", markersize=1, label="source, aligned")
    last.set(xlabel="x, mm", ylabel="y, mm", aspect="equal", title="the clouds, seen from above")
    last.legend(markerscale=8)
    figure.savefig(given.figure, dpi=120)
