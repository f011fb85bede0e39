# SPDX-License-Identifier: Apache-2.0
"""An independent ROS 2 node: Python's Cyclone DDS, with definitions of its own of ROS 2's messages."""

import dataclasses
import math
import time

from cyclonedds.internal import InvalidSample
from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import make_idl_struct
from cyclonedds.idl.annotations import final
from cyclonedds.idl.types import array, float32, float64, int32, sequence, uint8, uint32
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

LATCHED = Qos(
    Policy.Reliability.Reliable(duration(seconds=1)),
    Policy.Durability.TransientLocal,
    Policy.History.KeepLast(1),
    Policy.DataRepresentation(use_cdrv0_representation=True),
)


def message(package):
    """A dataclass as the message of a ROS 2 package of the same name."""

    def decorate(cls):
        typename = f"{package}.msg.dds_.{cls.__name__}_"
        return final(make_idl_struct(cls.__name__, typename, cls.__annotations__))

    return decorate


@message("builtin_interfaces")
class Time:
    sec: int32
    nanosec: uint32


@message("builtin_interfaces")
class Duration:
    sec: int32
    nanosec: uint32


@message("std_msgs")
class Header:
    stamp: Time
    frame_id: str


@message("std_msgs")
class String:
    data: str


@message("std_msgs")
class MultiArrayDimension:
    label: str
    size: uint32
    stride: uint32


@message("std_msgs")
class MultiArrayLayout:
    dim: sequence[MultiArrayDimension]
    data_offset: uint32


@message("std_msgs")
class Float64MultiArray:
    layout: MultiArrayLayout
    data: sequence[float64]


@message("std_msgs")
class Float32MultiArray:
    layout: MultiArrayLayout
    data: sequence[float32]


@message("sensor_msgs")
class JointState:
    header: Header
    name: sequence[str]
    position: sequence[float64]
    velocity: sequence[float64]
    effort: sequence[float64]


@message("sensor_msgs")
class PointField:
    name: str
    offset: uint32
    datatype: uint8
    count: uint32


@message("sensor_msgs")
class PointCloud2:
    header: Header
    height: uint32
    width: uint32
    fields: sequence[PointField]
    is_bigendian: bool
    point_step: uint32
    row_step: uint32
    data: sequence[uint8]
    is_dense: bool


@message("geometry_msgs")
class Vector3:
    x: float64
    y: float64
    z: float64


@message("geometry_msgs")
class Point:
    x: float64
    y: float64
    z: float64


@message("geometry_msgs")
class Quaternion:
    x: float64
    y: float64
    z: float64
    w: float64


@message("geometry_msgs")
class Pose:
    position: Point
    orientation: Quaternion


@message("geometry_msgs")
class PoseWithCovariance:
    pose: Pose
    covariance: array[float64, 36]


@message("geometry_msgs")
class PoseWithCovarianceStamped:
    header: Header
    pose: PoseWithCovariance


@message("geometry_msgs")
class PoseArray:
    header: Header
    poses: sequence[Pose]


@message("geometry_msgs")
class Transform:
    translation: Vector3
    rotation: Quaternion


@message("geometry_msgs")
class TransformStamped:
    header: Header
    child_frame_id: str
    transform: Transform


@message("tf2_msgs")
class TFMessage:
    transforms: sequence[TransformStamped]


@message("geometry_msgs")
class Wrench:
    force: Vector3
    torque: Vector3


@message("geometry_msgs")
class WrenchStamped:
    header: Header
    wrench: Wrench


@message("trajectory_msgs")
class JointTrajectoryPoint:
    positions: sequence[float64]
    velocities: sequence[float64]
    accelerations: sequence[float64]
    effort: sequence[float64]
    time_from_start: Duration


@message("trajectory_msgs")
class JointTrajectory:
    header: Header
    joint_names: sequence[str]
    points: sequence[JointTrajectoryPoint]


@message("std_msgs")
class ColorRGBA:
    r: float32
    g: float32
    b: float32
    a: float32


@message("sensor_msgs")
class CompressedImage:
    header: Header
    format: str
    data: sequence[uint8]


@message("visualization_msgs")
class UVCoordinate:
    u: float32
    v: float32


@message("visualization_msgs")
class MeshFile:
    filename: str
    data: sequence[uint8]


@message("visualization_msgs")
class Marker:
    header: Header
    ns: str
    id: int32
    type: int32
    action: int32
    pose: Pose
    scale: Vector3
    color: ColorRGBA
    lifetime: Duration
    frame_locked: bool
    points: sequence[Point]
    colors: sequence[ColorRGBA]
    texture_resource: str
    texture: CompressedImage
    uv_coordinates: sequence[UVCoordinate]
    text: str
    mesh_resource: str
    mesh_file: MeshFile
    mesh_use_embedded_materials: bool


@message("visualization_msgs")
class MarkerArray:
    markers: sequence[Marker]


@message("diagnostic_msgs")
class KeyValue:
    key: str
    value: str


@message("diagnostic_msgs")
class DiagnosticStatus:
    level: uint8
    name: str
    message: str
    hardware_id: str
    values: sequence[KeyValue]


@message("diagnostic_msgs")
class DiagnosticArray:
    header: Header
    status: sequence[DiagnosticStatus]


class _Impostor:
    numbers: sequence[uint32]


Impostor = final(make_idl_struct("Impostor", "sensor_msgs.msg.dds_.JointState_", _Impostor.__annotations__))


def stamp_of(nanoseconds):
    return Time(nanoseconds // 10**9, nanoseconds % 10**9)


def nanoseconds_of(stamp):
    return stamp.sec * 10**9 + stamp.nanosec


def converted(value, kind):
    """A decoded message of another library as one of these."""
    if isinstance(kind, type) and dataclasses.is_dataclass(kind):
        return kind(**{
            field.name: converted(getattr(value, field.name), field.type)
            for field in dataclasses.fields(kind)
        })  # fmt: skip
    inner = getattr(kind, "__metadata__", [None])[0]
    element = getattr(inner, "subtype", None)
    if element is not None and isinstance(element, type) and dataclasses.is_dataclass(element):
        return [converted(item, element) for item in value]
    return list(value) if isinstance(value, (list, tuple, bytes, bytearray)) else value


class Peer:
    """A participant with writers and readers by topic of ROS 2."""

    def __init__(self, domain, reliable=True):
        self.participant = DomainParticipant(domain)
        self.qos = Qos(
            Policy.Reliability.Reliable(duration(seconds=1)) if reliable else Policy.Reliability.BestEffort,
            Policy.Durability.Volatile,
            Policy.History.KeepAll,
            Policy.DataRepresentation(use_cdrv0_representation=True),
        )
        self.writers, self.readers = {}, {}

    def topic(self, name, kind):
        return Topic(self.participant, "rt" + name, kind, qos=self.qos)

    def write(self, name, value):
        if name not in self.writers:
            self.writers[name] = DataWriter(self.participant, self.topic(name, type(value)), qos=self.qos)
        self.writers[name].write(value)

    def advertise(self, name, kind):
        self.writers[name] = DataWriter(self.participant, self.topic(name, kind), qos=self.qos)

    def listen(self, name, kind, latched=False):
        """latched: what was sent before comes, too."""
        qos = LATCHED if latched else self.qos
        topic = Topic(self.participant, "rt" + name, kind, qos=qos)
        self.readers[name] = DataReader(self.participant, topic, qos=qos)

    def take(self, name):
        samples = self.readers[name].take(N=1000)
        return [sample for sample in samples if not isinstance(sample, InvalidSample)]

    def is_heard(self):
        return all(writer.get_matched_subscriptions() for writer in self.writers.values())

    def hears(self):
        return all(reader.get_matched_publications() for reader in self.readers.values())


def wait_until(condition, seconds=60):
    """Whether it became true; the limit is for tests that fail."""
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            return False
        time.sleep(0.005)
    return True


def restamped(value, now):
    """The message as if it were of another time, ns."""
    if not (hasattr(value, "transforms") or hasattr(value, "header")):
        return value  # an array
    stamps = [part.header for part in value.transforms] if hasattr(value, "transforms") else [value.header]
    for header in stamps:
        header.stamp = stamp_of(now)
    return value


def is_finite_pose(pose):
    numbers = [*dataclasses.astuple(pose.position), *dataclasses.astuple(pose.orientation)]
    return all(map(math.isfinite, numbers))
