// SPDX-License-Identifier: Apache-2.0
#include "palpate/tactile/biotac/skin.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "palpate/core/error.hpp"

namespace palpate::tactile {
namespace {

constexpr double kReach = 0.009;  // m, around a contact, in which taxels may carry it

/// A taxel's share of a load that grows linearly once a threshold is passed.
struct Share {
  double threshold, slope;
};

/// The x with sum slope_i max(0, x - threshold_i) = total.
double approach(std::vector<Share> shares, double total) {
  std::sort(shares.begin(), shares.end(),
            [](const Share& a, const Share& b) { return a.threshold < b.threshold; });
  double slope = 0, offset = 0, x = 0;
  for (std::size_t i = 0; i < shares.size(); ++i) {
    slope += shares[i].slope;
    offset += shares[i].slope * shares[i].threshold;
    x = (total + offset) / slope;
    if (i + 1 == shares.size() || x <= shares[i + 1].threshold) break;
  }
  return x;
}

/// The u with sum slope_i min(u, limit_i) = total; the largest limit where there is none.
double displacement(std::vector<Share> shares, double total) {
  std::sort(shares.begin(), shares.end(),
            [](const Share& a, const Share& b) { return a.threshold < b.threshold; });
  double slope = 0, carried = 0;
  for (const Share& share : shares) slope += share.slope;
  for (const Share& share : shares) {
    if (carried + slope * share.threshold >= total) return (total - carried) / slope;
    carried += share.slope * share.threshold;
    slope -= share.slope;
  }
  return shares.back().threshold;
}

}  // namespace

BiotacSkin::BiotacSkin(const SkinOptions& options)
    : options_(options), points_(3, kTaxels), normals_(3, kTaxels), areas_(kTaxels) {
  // Equal areas along x (Archimedes), turned by the golden angle.
  const double r = options.radius, reach = r + options.length;
  const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
  areas_.setConstant(2 * std::numbers::pi * r * reach / kTaxels);
  for (int i = 0; i < kTaxels; ++i) {
    const double x = r - reach * (i + 0.5) / kTaxels, turn = golden * i;
    const double ring = x > 0 ? std::sqrt(r * r - x * x) : r;
    points_.col(i) << x, ring * std::cos(turn), ring * std::sin(turn);
    normals_.col(i) = normal_at(points_.col(i));
  }
}

Eigen::Vector3d BiotacSkin::normal_at(const Eigen::Vector3d& p) const {
  const Eigen::Vector3d from_axis = p - Eigen::Vector3d(std::min(p.x(), 0.0), 0, 0);
  const double distance = from_axis.norm();
  return distance > 0 ? Eigen::Vector3d(from_axis / distance) : -Eigen::Vector3d::UnitZ();
}

Eigen::Vector3d BiotacSkin::on_skin(const Eigen::Vector3d& p) const {
  return Eigen::Vector3d(std::min(p.x(), 0.0), 0, 0) + options_.radius * normal_at(p);
}

SkinState BiotacSkin::press(std::span<const hand::TipContact> contacts,
                            const SurfaceDistance& surface) const {
  SkinState state;
  std::vector<std::vector<int>> taxels(contacts.size());
  for (const auto& contact : contacts) {
    if (!contact.p.allFinite() || !contact.n.allFinite() || !contact.f.allFinite()) {
      throw BadInput(fmt::format("a contact on the skin is not finite: force {} N, {} N, {} N",
                                 contact.f.x(), contact.f.y(), contact.f.z()));
    }
  }
  for (int i = 0; i < kTaxels; ++i) {
    std::size_t nearest = contacts.size();
    double least = kReach * kReach;
    for (std::size_t c = 0; c < contacts.size(); ++c) {
      const double squared = (points_.col(i) - contacts[c].p).squaredNorm();
      if (squared < least && normals_.col(i).dot(contacts[c].n) < 0) {
        least = squared;
        nearest = c;
      }
    }
    if (nearest < contacts.size()) taxels[nearest].push_back(i);
  }
  for (std::size_t c = 0; c < contacts.size(); ++c) load(contacts[c], taxels[c], surface, state);
  return state;
}

void BiotacSkin::load(const hand::TipContact& contact, const std::vector<int>& taxels,
                      const SurfaceDistance& surface, SkinState& state) const {
  const Eigen::Vector3d into = -contact.n;
  const double normal_force = contact.f.dot(into);
  if (normal_force <= 0) return;
  if (taxels.empty()) {
    state.off_skin = true;
    return;
  }
  std::vector<Share> shares;
  for (const int i : taxels) {
    const Eigen::Vector3d x = points_.col(i);
    const double away = (x - contact.p).squaredNorm() / (2 * options_.crown);
    const double height = away + (surface ? surface(x) : contact.n.dot(x - contact.p));
    shares.push_back({height, options_.stiffness * areas_[i] * normals_.col(i).dot(into)});
  }
  const double s = approach(shares, normal_force);
  Eigen::Vector3d shear = contact.f - normal_force * into;
  std::vector<Share> springs;
  for (std::size_t k = 0; k < taxels.size(); ++k) {
    const int i = taxels[k];
    state.depth[i] = std::max(0.0, s - shares[k].threshold);
    state.pressure[i] = options_.stiffness * state.depth[i];
    const Eigen::Vector3d force = areas_[i] * state.pressure[i] * normals_.col(i);
    state.force += force;
    shear -= force - force.dot(into) * into;
    if (state.pressure[i] > 0) {
      springs.push_back({options_.friction * state.pressure[i] / options_.shear_stiffness,
                         options_.shear_stiffness * areas_[i]});
    }
  }
  const double size = shear.norm();
  if (size < 1e-12 || springs.empty()) return;
  const double u = displacement(springs, size);
  for (const int i : taxels) {
    const double stress =
        std::min(options_.shear_stiffness * u, options_.friction * state.pressure[i]);
    state.shear.col(i) = stress * shear / size;
    state.force += areas_[i] * state.shear.col(i);
  }
}

}  // namespace palpate::tactile
