# SPDX-License-Identifier: Apache-2.0
"""Register two scans whose correspondences are mostly wrong, and read the certificate."""

import tempfile

import numpy as np

import palpate

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

# The same question about anyone's pose: how far is its cost above what can be proven?
right = result.inliers
print(palpate.certify(result.T_target_source, source[right], target[right]))

# Without correspondences: two clouds of the same object, matched by their features.
with tempfile.TemporaryDirectory() as folder:
    scan = f"{folder}/scan.ply"
    palpate.load_known_object("bracket").mesh.save(scan)
    source, target = palpate.load_cloud(scan, samples=6000), palpate.load_cloud(scan, samples=8000)
moved = palpate.PointCloud(target.points @ truth[:3, :3].T + truth[:3, 3])
clouds = palpate.register_clouds(palpate.PointCloud(source.points), moved)
print(clouds)
print(clouds.result.T_target_source)
