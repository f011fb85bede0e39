// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tasks/relocate/relocate_scene.hpp"
#include "tasks/relocate/sparse_observation.hpp"

namespace palpate::relocate {

struct RelocateModel::Impl {
  RelocateScene scene;
  RelocateAction center, half_range;
  double start_height = 0;
};

struct RelocateTask::Impl {
  explicit Impl(const RelocateModel& m);

  const RelocateScene& scene() const { return model.impl().scene; }
  Eigen::Vector3d palm() const;    ///< m
  Eigen::Vector3d object() const;  ///< of its frame's origin, m
  bool contact() const;            ///< of hand and object
  int touching_tips() const;       ///< fingertips that touch the object

  RelocateJoints noisy_joints();
  void read_encoders();  ///< of the joints, at the end of a control step

  RelocateModel model;  // shares the compiled model, which must outlive the data
  simulation::DataHandle data;
  RelocateStart start;
  SparseObservation seen;
  RandomStream encoder_noise{0};
  RelocateJoints read = RelocateJoints::Zero(), velocity = RelocateJoints::Zero();  // of encoders
};

}  // namespace palpate::relocate
