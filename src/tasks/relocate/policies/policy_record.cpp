// SPDX-License-Identifier: Apache-2.0
#include "tasks/relocate/policies/policy_record.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "palpate/core/error.hpp"

namespace palpate::relocate {

std::vector<double> to_array(const Eigen::VectorXd& values) {
  return {values.begin(), values.end()};
}

std::vector<int> layer_sizes(const Eigen::VectorXd& numbers) {
  constexpr double kMost = 1e6;
  std::vector<int> sizes;
  for (const double size : numbers) {
    if (!(size >= 1 && size <= kMost) || size != std::floor(size)) {
      throw BadInput(fmt::format("a network with a layer of {} units", size));
    }
    sizes.push_back(static_cast<int>(size));
  }
  return sizes;
}

Eigen::VectorXd array(const PolicyRecord& record, const std::string& name) {
  const auto found = record.arrays.find(name);
  if (found == record.arrays.end()) {
    throw BadInput(fmt::format("a policy of kind '{}' without '{}'", record.kind, name));
  }
  return Eigen::VectorXd::Map(found->second.data(), std::ssize(found->second));
}

void check_arrays(const PolicyRecord& record, const std::vector<std::string>& names) {
  for (const auto& name : names) array(record, name);
  for (const auto& [name, values] : record.arrays) {
    if (std::find(names.begin(), names.end(), name) == names.end()) {
      throw BadInput(fmt::format("a policy of kind '{}' with an unknown '{}'", record.kind, name));
    }
  }
}

}  // namespace palpate::relocate
