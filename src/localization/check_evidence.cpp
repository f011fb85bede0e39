// SPDX-License-Identifier: Apache-2.0
#include "check_evidence.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numeric>

#include "palpate/core/error.hpp"

namespace palpate::localization {
namespace {

constexpr double kUnitTolerance = 1e-3;

void check_positive(const std::string& what, double value) {
  if (!(std::isfinite(value) && value > 0)) {
    throw BadInput(fmt::format("{} is {}, not positive", what, value));
  }
}

void check_not_negative(const std::string& what, double value) {
  if (!(std::isfinite(value) && value >= 0)) {
    throw BadInput(fmt::format("{} is {}, not finite and >= 0", what, value));
  }
}

void check_finite(const std::string& what, const Eigen::Vector3d& v) {
  if (!v.allFinite()) {
    throw BadInput(fmt::format("{} is ({}, {}, {}), not finite", what, v.x(), v.y(), v.z()));
  }
}

void check_contact(const touch::Contact& contact, std::size_t index) {
  const std::string name = fmt::format("contact {}: ", index);
  check_finite(name + "point", contact.p);
  check_finite(name + "normal", contact.n);
  if (!(std::abs(contact.n.norm() - 1) < kUnitTolerance)) {
    throw BadInput(fmt::format("{}normal has length {}, not 1", name, contact.n.norm()));
  }
  check_positive(name + "point_sigma", contact.point_sigma);
  check_positive(name + "normal_sigma", contact.normal_sigma);
}

void check_stance_weights(const std::vector<double>& weights, std::size_t stances) {
  if (stances == 0) throw BadInput("table: the object has 0 stances");
  if (weights.empty()) return;
  if (weights.size() != stances) {
    throw BadInput(fmt::format("table: {} stance weights for {} stances", weights.size(), stances));
  }
  for (const double weight : weights) check_not_negative("table: a stance weight", weight);
  check_positive("table: the sum of the stance weights",
                 std::accumulate(weights.begin(), weights.end(), 0.0));
}

void check_table(const TableSupport& table, std::size_t stances) {
  if (!table.T_frame_table.matrix().allFinite()) {
    throw BadInput("table: T_frame_table holds a value that is not finite");
  }
  check_stance_weights(table.stance_weights, stances);
  check_positive("table: tilt_sigma", table.tilt_sigma);
  check_positive("table: height_sigma", table.height_sigma);
  check_positive("table: edge_sigma", table.edge_sigma);
  check_not_negative("table: half_width", table.half_width);
}

}  // namespace

void check_evidence(const ObjectModel& model, const Evidence& evidence) {
  for (std::size_t k = 0; k < evidence.contacts.size(); ++k) check_contact(evidence.contacts[k], k);
  for (std::size_t j = 0; j < evidence.free_space.size(); ++j) {
    const std::string name = fmt::format("free sphere {}: ", j);
    check_finite(name + "center", evidence.free_space[j].center);
    check_not_negative(name + "radius", evidence.free_space[j].radius);
  }
  check_positive("penetration_sigma", evidence.penetration_sigma);
  const double share = evidence.false_contact_share;
  if (!(share > 0 && share < 1)) {
    throw BadInput(fmt::format("false_contact_share is {}, not between 0 and 1", share));
  }
  if (evidence.table) check_table(*evidence.table, model.object().stances.size());
}

}  // namespace palpate::localization
