# SPDX-License-Identifier: Apache-2.0
"""Free space as other sensors and maps give it, for palpate.localize(free_space=)."""

import numpy as np

from . import _core


def free_space_of_voxels(
    free: "np.typing.ArrayLike", pitch: float, T_frame_grid: "np.typing.ArrayLike | None" = None
) -> "np.ndarray":
    """Balls, rows x, y, z, radius (N, 4), m, that lie in the free voxels of a grid.

    free (X, Y, Z), bool: true where nothing of the object is; what is not known is false. pitch: m,
    of a voxel. T_frame_grid (4, 4): the grid's frame, its axes along the indices, its origin the
    outer corner of voxel 0, 0, 0; the identity if not given.

    Voxels are joined to cubes of 2, 4, 8.. as far as all of one are free, each of which gives the
    ball inside it; so a ball never says more than the voxels do, and the corners are left out.
    `localize(free_space=)` takes them, and those of several grids, one below the other.

    Raises ValueError for another shape, a pitch that is not positive and finite, and what is no pose.
    """
    cubes = np.asarray(free, dtype=bool)
    if cubes.ndim != 3:
        raise ValueError(f"free has shape {cubes.shape}, not (X, Y, Z)")
    if not (np.isfinite(pitch) and pitch > 0):
        raise ValueError(f"pitch is {pitch} m, not positive")
    balls, size = [], 1
    while cubes.any():
        padded = np.pad(cubes, [(0, n % 2) for n in cubes.shape])
        x, y, z = (n // 2 for n in padded.shape)
        joined = padded.reshape(x, 2, y, 2, z, 2).all(axis=(1, 3, 5))
        part_of_joined = joined.repeat(2, 0).repeat(2, 1).repeat(2, 2)
        corners = np.argwhere(padded & ~part_of_joined)
        centers = (corners + 0.5) * size * pitch
        balls.append(np.column_stack([centers, np.full(len(centers), size * pitch / 2)]))
        cubes, size = joined, 2 * size
    result = np.vstack([np.empty((0, 4)), *balls])
    if T_frame_grid is not None:
        contacts = _core.Contacts(result[:, :3]).transformed(T_frame_grid)
        result[:, :3] = contacts.points
    return result
