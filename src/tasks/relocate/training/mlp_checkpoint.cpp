// SPDX-License-Identifier: Apache-2.0
#include "tasks/relocate/training/mlp_checkpoint.hpp"

#include <algorithm>
#include <string>
#include <string_view>

#include "tasks/relocate/policies/policy_record.hpp"

namespace palpate::relocate {
namespace {

constexpr std::string_view kPrefix = "policy_", kSizes = "policy_sizes";

}  // namespace

void save_mlp(const PolicyRecord& record, learning::Checkpoint& checkpoint) {
  Eigen::VectorXd sizes(std::ssize(record.sizes));
  std::copy(record.sizes.begin(), record.sizes.end(), sizes.begin());
  checkpoint.arrays[std::string(kSizes)] = sizes;
  for (const auto& [name, values] : record.arrays) {
    checkpoint.arrays[std::string(kPrefix) + name] = array(record, name);
  }
}

PolicyRecord restore_mlp(const learning::Checkpoint& checkpoint) {
  PolicyRecord record;
  record.kind = "mlp";
  record.sizes = layer_sizes(checkpoint.array(std::string(kSizes)).reshaped());
  for (const auto& [name, values] : checkpoint.arrays) {
    if (!name.starts_with(kPrefix) || name == kSizes) continue;
    record.arrays[name.substr(kPrefix.size())] = to_array(values.reshaped());
  }
  return record;
}

}  // namespace palpate::relocate
