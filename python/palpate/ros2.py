# SPDX-License-Identifier: Apache-2.0
"""Contacts from ROS 2 topics and estimates to them, without an installation of ROS.

`pip install palpate[ros2]` adds what it needs: Python's Cyclone DDS. The topics are those of
`palpate ros2`: /contacts/FINGER in, /palpate/estimate, /palpate/modes, /palpate/mode_weights and
/palpate/status out. ROS_DOMAIN_ID and CYCLONEDDS_URI choose domain and network, as for a ROS node.
"""

import operator as _operator
import os as _os
import re as _re
import time as _time

import numpy as _np

from ._core import Contacts as _Contacts
from ._core import Sensor as _Sensor

try:
    from cyclonedds.core import Policy as _Policy
    from cyclonedds.core import Qos as _Qos
    from cyclonedds.domain import DomainParticipant as _DomainParticipant
    from cyclonedds.pub import DataWriter as _DataWriter
    from cyclonedds.sub import DataReader as _DataReader
    from cyclonedds.topic import Topic as _Topic
    from cyclonedds.util import duration as _duration
except ImportError as error:
    raise ImportError(f"palpate.ros2 needs palpate[ros2] (cyclonedds): {error}") from error

from . import _ros2_messages as _messages

__all__ = ["EstimatePublisher", "Node", "TopicSensor", "contacts_of_cloud"]

_FLOATS = {7: "<f4", 8: "<f8"}  # sensor_msgs/PointField
_XYZ = ("x", "y", "z")
_NORMAL = ("normal_x", "normal_y", "normal_z")
_FORCE = ("force_x", "force_y", "force_z")
_SIGMAS = {"point_sigma": 0.001, "normal_sigma": _np.radians(10)}  # m, rad: where none is stated
_MOST_OF_A_NORMAL = _np.pi / 2  # rad: nothing is known of it
_MAX_DOMAIN = 232


def _default_domain():
    """ROS_DOMAIN_ID, or 0 where it is not set or empty."""
    text = _os.environ.get("ROS_DOMAIN_ID", "")
    if not text:
        return 0
    if not (_re.fullmatch("-?[0-9]+", text) and 0 <= int(text) <= _MAX_DOMAIN):
        raise ValueError(f"ROS_DOMAIN_ID is {text!r}, not 0 to {_MAX_DOMAIN}")
    return int(text)


def _domain(domain):
    number = _operator.index(domain)
    if not 0 <= number <= _MAX_DOMAIN:
        raise ValueError(f"domain is {number}, not 0 to {_MAX_DOMAIN}")
    return number


class Node:
    """A participant in a ROS 2 domain: ROS_DOMAIN_ID, or 0, unless `domain` is given.

    Raises ValueError for a domain that is not 0 to 232.
    """

    def __init__(self, domain=None):
        self.domain = _default_domain() if domain is None else _domain(domain)
        self._participant = _DomainParticipant(self.domain)
        self._qos = _Qos(
            _Policy.Reliability.Reliable(_duration(seconds=1)),
            _Policy.Durability.Volatile,
            _Policy.History.KeepLast(10),
            _Policy.DataRepresentation(use_cdrv0_representation=True),
        )

    def _topic(self, name, kind):
        return _Topic(self._participant, "rt" + name, kind, qos=self._qos)

    def _writer(self, name, kind):
        return _DataWriter(self._participant, self._topic(name, kind), qos=self._qos)

    def _reader(self, name, kind):
        return _DataReader(self._participant, self._topic(name, kind), qos=self._qos)

    def __repr__(self):
        return f"Node(domain {self.domain})"


def _columns(cloud, values, names):
    """(N, 3) of three fields; None where one is missing."""
    fields = {field.name: field for field in cloud.fields}
    if not all(name in fields for name in names):
        return None
    columns = []
    for name in names:
        field = fields[name]
        kind = _FLOATS.get(field.datatype)
        if kind is None or field.offset + int(kind[-1]) > cloud.point_step:
            raise ValueError(
                f"field {name} of type {field.datatype} at byte {field.offset} of points of "
                f"{cloud.point_step} bytes"
            )
        size = int(kind[-1])
        column = _np.ascontiguousarray(values[:, field.offset : field.offset + size])
        columns.append(column.view(kind)[:, 0].astype(float))
    return _np.stack(columns, axis=1)


def _sigmas(cloud, values):
    """The errors that the points state, and the usual one for those that state none, (N,) each."""
    sigmas = {}
    for name, usual in _SIGMAS.items():
        column = _columns(cloud, values, (name,))
        if column is None:
            continue
        column = column[:, 0]
        if _np.isnan(column).any():
            raise ValueError(f"contact {_np.isnan(column).argmax()}: {name} is nan")
        sigmas[name] = _np.where(column > 0, column, usual)
    if "normal_sigma" in sigmas:
        sigmas["normal_sigma"] = _np.minimum(sigmas["normal_sigma"], _MOST_OF_A_NORMAL)
    return sigmas


def contacts_of_cloud(cloud):
    """Contacts of a sensor_msgs/PointCloud2, in its frame.

    Fields x, y, z (m); where there are any, normal_x, normal_y, normal_z: outward of the object;
    force_x, force_y, force_z: of the finger on the object (N); point_sigma (m, at most 0.1) and
    normal_sigma (rad; more than pi/2 counts as pi/2), of which 0 means not stated: 0.001 m, 10 deg.
    32 or 64-bit floats. Returns Contacts of N points.

    Raises ValueError for a cloud without x, y, z, other types, data that do not fit, and errors
    that are nan or too large.
    """
    count = cloud.width * cloud.height
    data = _np.frombuffer(bytes(cloud.data), dtype=_np.uint8)
    row = cloud.width * cloud.point_step
    if cloud.is_bigendian or cloud.row_step < row or len(data) < cloud.row_step * cloud.height:
        raise ValueError(
            f"a cloud of {cloud.height} x {cloud.width} points of {cloud.point_step} bytes, in rows "
            f"of {cloud.row_step} and {len(data)} bytes of data, "
            f"{'big' if cloud.is_bigendian else 'little'} endian"
        )
    rows = data[: cloud.row_step * cloud.height].reshape(cloud.height, cloud.row_step)
    values = rows[:, :row].reshape(count, cloud.point_step)
    points = _columns(cloud, values, _XYZ)
    if points is None:
        raise ValueError(f"a cloud of {', '.join(field.name for field in cloud.fields)}, not x, y, z")
    normals, forces = _columns(cloud, values, _NORMAL), _columns(cloud, values, _FORCE)
    return _Contacts(points, normals, forces, **_sigmas(cloud, values))


class TopicSensor(_Sensor):
    """The sensor of a fingertip whose contacts come by a topic, for `palpate.sim.pick(sensors=)`.

    node: a Node; finger: its name in the hand's description; topic: /contacts/FINGER unless given.
    The clouds are in the frame of the fingertip's link.
    """

    def __init__(self, node, finger, topic=None):
        super().__init__(finger)
        self._reader = node._reader(topic or f"/contacts/{finger}", _messages.PointCloud2)

    def read(self):
        """The newest Contacts; None where no message has come since the last call.

        Raises ValueError for a cloud that contacts_of_cloud() refuses.
        """
        newest = None
        for sample in self._reader.take(N=100):
            if isinstance(sample, _messages.PointCloud2):  # else the end of a publisher
                newest = sample
        return None if newest is None else contacts_of_cloud(newest)


def _quat_xyzw(rotation):
    """Of a rotation (3, 3): the eigenvector of Bar-Itzhack's matrix (2000) of the largest value."""
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = rotation
    matrix = _np.array([
        [xx - yy - zz, yx + xy, zx + xz, zy - yz],
        [yx + xy, yy - xx - zz, zy + yz, xz - zx],
        [zx + xz, zy + yz, zz - xx - yy, yx - xy],
        [zy - yz, xz - zx, yx - xy, xx + yy + zz],
    ])  # fmt: skip
    quat = _np.linalg.eigh(matrix)[1][:, -1]
    return quat if quat[3] >= 0 else -quat


def _pose(T):
    return _messages.Pose(
        _messages.Point(*map(float, T[:3, 3])),
        _messages.Quaternion(*map(float, _quat_xyzw(T[:3, :3]))),
    )


class EstimatePublisher:
    """Publishes posteriors as `palpate ros2 estimate` does.

    node: a Node; frame: of the contacts that the posteriors come from.
    """

    def __init__(self, node, frame="world"):
        self.frame = frame
        self._estimate = node._writer("/palpate/estimate", _messages.PoseWithCovarianceStamped)
        self._modes = node._writer("/palpate/modes", _messages.PoseArray)
        self._weights = node._writer("/palpate/mode_weights", _messages.Float64MultiArray)
        self._status = node._writer("/palpate/status", _messages.String)

    @property
    def subscribers(self):
        """How many nodes listen to the estimate now."""
        return len(self._estimate.get_matched_subscriptions())

    def publish(self, posterior, time_ns=None):
        """Sends a palpate.Posterior; time_ns: of its contacts, now if not given.

        The best pose is not sent where there is none; modes, weights and status always are.
        """
        nanoseconds = _time.time_ns() if time_ns is None else time_ns
        stamp = _messages.Time(nanoseconds // 10**9, nanoseconds % 10**9)
        header = _messages.Header(stamp, self.frame)
        modes = posterior.modes
        if modes:
            order = [3, 4, 5, 0, 1, 2]  # ROS has the translation first
            covariance = modes[0].family_covariance[_np.ix_(order, order)]
            pose = _messages.PoseWithCovariance(
                _pose(modes[0].T_frame_object), covariance.ravel().tolist()
            )
            self._estimate.write(_messages.PoseWithCovarianceStamped(header, pose))
        self._modes.write(_messages.PoseArray(header, [_pose(m.T_frame_object) for m in modes]))
        layout = _messages.MultiArrayLayout(
            [_messages.MultiArrayDimension("modes", len(modes), len(modes))], 0
        )
        self._weights.write(_messages.Float64MultiArray(layout, [m.weight for m in modes]))
        self._status.write(_messages.String(posterior.status))
