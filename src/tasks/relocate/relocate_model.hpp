// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tasks/relocate/relocate_scene.hpp"

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

  RelocateModel model;  // shares the compiled model, which must outlive the data
  simulation::DataHandle data;
  Eigen::Vector3d target = Eigen::Vector3d::Zero();
};

}  // namespace palpate::relocate
