// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <tuple>

#include "palpate/registration/cloud_registration.hpp"
#include "pickle.hpp"

namespace palpate::python {

// What pickles keep of registrations.

template <>
struct Fields<registration::RobustBound> {
  static auto of(registration::RobustBound& it) {
    return std::tie(it.max_inliers, it.min_cost, it.cost, it.is_exhausted, it.nodes, it.seconds);
  }
};
template <>
struct Fields<registration::RegistrationCertificate> {
  static auto of(registration::RegistrationCertificate& it) {
    return std::tie(it.least_squares, it.resolution_deg, it.robust);
  }
};
template <>
struct Fields<registration::RunnerUp> {
  static auto of(registration::RunnerUp& it) {
    return std::tie(it.inliers, it.T_target_source, it.false_alarms);
  }
};
template <>
struct Fields<registration::FreeMotion> {
  static auto of(registration::FreeMotion& it) {
    return std::tie(it.kind, it.direction, it.point, it.pitch);
  }
};
template <>
struct Fields<registration::RegistrationResult> {  // what Python cannot see is left out
  static auto of(registration::RegistrationResult& it) {
    return std::tie(it.status, it.T_target_source, it.scale, it.inliers, it.weights, it.residuals,
                    it.cost, it.bound, it.false_alarms, it.certificate, it.runner_up, it.instances,
                    it.mirrored, it.false_inliers, it.free_motions, it.covariance, it.seconds);
  }
};
template <>
struct Fields<registration::PoseEstimate> {
  static auto of(registration::PoseEstimate& it) {
    return std::tie(it.status, it.T_target_source, it.cost, it.bound, it.rank);
  }
};
template <>
struct Fields<registration::CloudRegistration> {
  static auto of(registration::CloudRegistration& it) {
    return std::tie(it.result, it.overlap, it.contradiction, it.rms_error, it.noise_bound, it.voxel,
                    it.feature_matches, it.feature_inliers, it.refinements,
                    it.correspondences.source, it.correspondences.target);
  }
};

}  // namespace palpate::python
