# SPDX-License-Identifier: Apache-2.0
"""Hands, contacts and posteriors in the Rerun viewer, while they are computed.

`pip install palpate[live]` adds it. Begin with `rerun.init("palpate", spawn=True)`, which opens
the viewer, or `rerun.save("pick.rrd")` after `rerun.init("palpate")`, which writes a file for it.
Entities stand in the world's frame, metres; the timeline `robot_time` is the hand's.
"""

import numpy as _np

from ._core import Hand as _Hand

try:
    import rerun as _rerun
except ImportError as error:
    raise ImportError(f"palpate.live needs palpate[live] (rerun-sdk): {error}") from error

__all__ = ["WatchedHand", "show_contacts", "show_posterior"]

_NORMAL_LENGTH = 0.02  # m
_FORCE_LENGTH = 0.01  # m/N


def show_contacts(contacts, entity="contacts"):
    """Shows Contacts: their points (N, 3), m, and their normals, where they are known."""
    points = contacts.points
    _rerun.log(entity, _rerun.Points3D(points, radii=0.002))
    if contacts.normals is not None:
        known = _np.isfinite(contacts.normals).all(axis=1)
        arrows = _rerun.Arrows3D(
            origins=points[known], vectors=_NORMAL_LENGTH * contacts.normals[known]
        )
        _rerun.log(f"{entity}/normals", arrows)


def show_posterior(posterior, mesh, entity="posterior"):
    """Shows a Posterior: the object's Mesh at each of its modes, as opaque as the mode is probable,
    and the weights.

    mesh: of the object, as ObjectModel.object.mesh. What was shown before gives way.
    """
    _rerun.log(entity, _rerun.Clear(recursive=True))
    for index, mode in enumerate(posterior.modes):
        T = mode.T_frame_object
        place = f"{entity}/{index}"
        _rerun.log(place, _rerun.Transform3D(translation=T[:3, 3], mat3x3=T[:3, :3]))
        color = [80, 160, 255, int(55 + 200 * mode.weight)]
        shape = _rerun.Mesh3D(
            vertex_positions=mesh.vertices, triangle_indices=mesh.triangles, albedo_factor=color
        )
        _rerun.log(f"{place}/mesh", shape)
        _rerun.log(f"{entity}_weight/{index}", _rerun.Scalars(mode.weight))
    _rerun.log(f"{entity}_status", _rerun.TextLog(repr(posterior)))


class WatchedHand(_Hand):
    """Another Hand that is shown while it is used: its mount, the force on it, and the forces of its
    fingertips.

    hand: a palpate.Hand, which is stepped as before; every: ticks of 10 ms between two pictures.
    """

    def __init__(self, hand, every=5):
        super().__init__(hand.description)
        if every < 1:
            raise ValueError(f"every must be at least 1, not {every}")
        self._hand, self._every, self._ticks = hand, every, 0

    def sense(self):
        """As the other hand's."""
        return self._hand.sense()

    def step(self, command):
        """As the other hand's."""
        reading = self._hand.step(command)
        if self._ticks % self._every == 0:
            self._show(command, reading)
        self._ticks += 1
        return reading

    def _show(self, command, reading):
        _rerun.set_time("robot_time", duration=reading.time)
        place = _rerun.Points3D([reading.mount_xyz, command.mount_xyz], radii=[0.01, 0.005])
        _rerun.log("hand/mount", place)
        force = _FORCE_LENGTH * reading.mount_force
        _rerun.log("hand/mount_force", _rerun.Arrows3D(origins=[reading.mount_xyz], vectors=[force]))
        for finger, contacts in zip(self.description.fingers, reading.contacts):
            total = float(_np.linalg.norm(sum((c.force for c in contacts), _np.zeros(3))))
            _rerun.log(f"hand/force/{finger.name}", _rerun.Scalars(total))
