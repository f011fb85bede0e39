# SPDX-License-Identifier: Apache-2.0
"""Contacts with a box, as tests of the package use them."""

import numpy as np

BOX = (0.05, 0.094, 0.175)


def box_points(count, seed=1):
    """Exact points and normals on a box of BOX m about its centre."""
    random = np.random.default_rng(seed)
    half = np.array(BOX) / 2
    points = random.uniform(-0.8, 0.8, (count, 3)) * half
    normals = np.zeros((count, 3))
    for i in range(count):
        axis, side = i % 3, 1 - 2 * (i // 3 % 2)
        points[i, axis], normals[i, axis] = side * half[axis], side
    return points, normals
