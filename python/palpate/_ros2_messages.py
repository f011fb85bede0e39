# SPDX-License-Identifier: Apache-2.0
"""The ROS 2 messages that palpate.ros2 uses, as they go over the wire."""

from cyclonedds.idl import make_idl_struct
from cyclonedds.idl.annotations import final
from cyclonedds.idl.types import array, float64, int32, sequence, uint8, uint32


def _message(package, name, /, **fields):
    return final(make_idl_struct(name, f"{package}.msg.dds_.{name}_", fields))


Time = _message("builtin_interfaces", "Time", sec=int32, nanosec=uint32)
Header = _message("std_msgs", "Header", stamp=Time, frame_id=str)
String = _message("std_msgs", "String", data=str)
MultiArrayDimension = _message(
    "std_msgs", "MultiArrayDimension", label=str, size=uint32, stride=uint32
)
MultiArrayLayout = _message(
    "std_msgs", "MultiArrayLayout", dim=sequence[MultiArrayDimension], data_offset=uint32
)
Float64MultiArray = _message(
    "std_msgs", "Float64MultiArray", layout=MultiArrayLayout, data=sequence[float64]
)
PointField = _message(
    "sensor_msgs", "PointField", name=str, offset=uint32, datatype=uint8, count=uint32
)
PointCloud2 = _message(
    "sensor_msgs", "PointCloud2", header=Header, height=uint32, width=uint32,
    fields=sequence[PointField], is_bigendian=bool, point_step=uint32, row_step=uint32,
    data=sequence[uint8], is_dense=bool,
)  # fmt: skip
Point = _message("geometry_msgs", "Point", x=float64, y=float64, z=float64)
Quaternion = _message("geometry_msgs", "Quaternion", x=float64, y=float64, z=float64, w=float64)
Pose = _message("geometry_msgs", "Pose", position=Point, orientation=Quaternion)
PoseWithCovariance = _message(
    "geometry_msgs", "PoseWithCovariance", pose=Pose, covariance=array[float64, 36]
)
PoseWithCovarianceStamped = _message(
    "geometry_msgs", "PoseWithCovarianceStamped", header=Header, pose=PoseWithCovariance
)
PoseArray = _message("geometry_msgs", "PoseArray", header=Header, poses=sequence[Pose])
