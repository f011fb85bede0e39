# SPDX-License-Identifier: Apache-2.0
"""Palpate: the pose of an object from touch alone.

SI units and radians; another unit stands in the name. Poses are (4, 4) float64 arrays in C order,
`T_a_b` maps frame b to frame a; points are (N, 3). Bad input raises ValueError with one line that
names the value; a failure that is to be expected is a status in the result. All randomness comes
from `seed=`.
"""

import sys as _sys

from ._core import (
    Actuator,
    Arm,
    ArmDescription,
    ArmFollower,
    ArmJoint,
    ArmReading,
    BasePosition,
    ClosestPoints,
    CloudRegistration,
    Contacts,
    Finger,
    FreeAxis,
    FreeMotion,
    Hand,
    HandCommand,
    HandDescription,
    HandJoint,
    HandLink,
    HandReading,
    HeldPoseFollower,
    Identification,
    KnownObject,
    Mesh,
    Mode,
    NormalEstimate,
    NormalEstimator,
    ObjectModel,
    PathFeasibility,
    PointCloud,
    PoseEstimate,
    PosePrior,
    Posterior,
    PredictedTouch,
    RegistrationCertificate,
    RegistrationResult,
    RobustBound,
    RunnerUp,
    Sensor,
    StablePose,
    TableSupport,
    TipContact,
    TouchAction,
    Tracker,
    __version__,
    built_in_objects,
    certify,
    choose_touch,
    contact_of_wrench,
    contacts_of_height_map,
    contacts_of_taxels,
    free_space_of_voxels,
    identify,
    load_cloud,
    load_known_object,
    load_mesh,
    localize,
    make_known_object,
    normal_estimators,
    pose_error,
    predict_touch,
    prior_from,
    read_contacts,
    register_clouds,
    register_correspondences,
    register_described,
    working_tour,
)

__all__ = [name for name in dir() if not name.startswith("_")]

if "gymnasium" in _sys.modules:  # importing it here would cost more than all the rest
    from . import envs
