// SPDX-License-Identifier: Apache-2.0
#include "palpate/tactile/sensors/taxel_array.hpp"

#include <fmt/format.h>

#include <cmath>

#include "palpate/core/error.hpp"

namespace palpate::tactile {
namespace {

constexpr double kUnitTolerance = 1e-3;

void check_taxel(const Taxel& taxel, std::size_t index) {
  if (!(taxel.p.allFinite() && std::isfinite(taxel.force))) {
    throw BadInput(fmt::format("taxel {}: point ({}, {}, {}) or force {} is not finite", index,
                               taxel.p.x(), taxel.p.y(), taxel.p.z(), taxel.force));
  }
  if (!(std::abs(taxel.n.norm() - 1) < kUnitTolerance)) {
    throw BadInput(fmt::format("taxel {}: normal has length {}, not 1", index, taxel.n.norm()));
  }
}

}  // namespace

std::vector<Contact> contacts_of_taxels(const std::vector<Taxel>& taxels,
                                        const Eigen::Isometry3d& T_frame_sensor,
                                        const TaxelOptions& options) {
  const Eigen::Vector3d limits(options.min_force, options.pitch, options.normal_sigma);
  if (!(limits.allFinite() && limits.minCoeff() > 0)) {
    throw BadInput(
        fmt::format("taxels: min_force, pitch and normal_sigma are {}, {} and {}, not "
                    "all positive and finite",
                    options.min_force, options.pitch, options.normal_sigma));
  }
  std::vector<Contact> contacts;
  for (std::size_t i = 0; i < taxels.size(); ++i) {
    const Taxel& taxel = taxels[i];
    check_taxel(taxel, i);
    if (!(taxel.force > options.min_force)) continue;
    Contact contact;
    contact.p = T_frame_sensor * taxel.p;
    contact.n = -(T_frame_sensor.linear() * taxel.n);
    contact.f = -taxel.force * contact.n;
    contact.point_sigma = options.pitch / std::sqrt(12.0);
    contact.normal_sigma = options.normal_sigma;
    contacts.push_back(contact);
  }
  return contacts;
}

}  // namespace palpate::tactile
