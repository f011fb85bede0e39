// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "palpate/localization/identification.hpp"

namespace palpate::app {

/// What localize found.
struct LocalizeResult {
  std::vector<std::string> names;             // of the objects
  localization::ObjectProbabilities objects;  // which one it is
  localization::Posterior posterior;          // of the most probable one
  /// The search's object frame is at the centroid, the file's is not.
  Eigen::Isometry3d T_object_mesh = Eigen::Isometry3d::Identity();
  std::vector<std::string> repairs;
  std::string hint, method;
  bool ignore_spin = false;
  double prepare_seconds = 0;
};

nlohmann::json report_of(const LocalizeResult& result);
void print_result(const LocalizeResult& result);

}  // namespace palpate::app
