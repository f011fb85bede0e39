// SPDX-License-Identifier: Apache-2.0
#include "palpate/localization/sizes.hpp"

#include <algorithm>
#include <functional>
#include <limits>

#include "localization/likelihood/goodness_of_fit.hpp"
#include "palpate/core/se3.hpp"

namespace palpate::localization {
namespace {

/// Indices of the candidates of a candidate's shape.
std::vector<std::size_t> sizes_of(const SizedCandidates& candidates, std::size_t candidate) {
  std::vector<std::size_t> sizes;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (geometry::is_same_shape(*candidates[i], *candidates[candidate])) sizes.push_back(i);
  }
  return sizes;
}

double sum_over(const std::vector<std::size_t>& sizes, const ObjectProbabilities& objects) {
  double sum = 0;
  for (const std::size_t i : sizes) sum += objects.candidates[i];
  return sum;
}

/// What a pose is off another, modulo symmetry: [rotation; translation], frame's axes.
Vector6d between(const Eigen::Isometry3d& T, const Eigen::Isometry3d& reference,
                 const std::vector<Eigen::Matrix3d>& symmetries) {
  Vector6d best;
  double least = std::numeric_limits<double>::infinity();
  for (const Eigen::Matrix3d& turn : symmetries) {
    const Eigen::Vector3d w = log_so3(T.linear() * turn * reference.linear().transpose());
    if (w.norm() >= least) continue;
    least = w.norm();
    best << w, T.translation() - reference.translation();
  }
  return best;
}

/// Takes a mode into one that it is next to.
void merge(const Mode& mode, const std::vector<Eigen::Matrix3d>& symmetries, Mode& into) {
  const Vector6d apart = between(mode.T_frame_object, into.T_frame_object, symmetries);
  const double weight = into.weight + mode.weight;
  if (!(weight > 0)) return;
  into.covariance = (into.weight * into.covariance +
                     mode.weight * (mode.covariance + apart * apart.transpose())) /
                    weight;
  into.weight = weight;
}

void add(const Mode& mode, const std::vector<Eigen::Matrix3d>& symmetries,
         std::vector<Mode>& modes) {
  const auto near = std::ranges::find_if(modes, [&](const Mode& other) {
    return other.free_axis.has_value() == mode.free_axis.has_value() &&
           within(mode_error(other, mode.T_frame_object, symmetries));
  });
  if (near == modes.end()) {
    modes.push_back(mode);
  } else {
    merge(mode, symmetries, *near);
  }
}

}  // namespace

void choose_shape(const SizedCandidates& candidates, ObjectProbabilities& objects) {
  objects.probability = 0;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const double sum = sum_over(sizes_of(candidates, i), objects);
    const bool likelier = objects.candidates[i] > objects.candidates[objects.best];
    if (sum < objects.probability || (sum == objects.probability && !likelier)) continue;
    objects.probability = sum;
    objects.best = i;
  }
  if (!(objects.probability > 0)) return;
  objects.size = 0;
  for (const std::size_t i : sizes_of(candidates, objects.best)) {
    objects.size += objects.candidates[i] / objects.probability * candidates[i]->size;
  }
}

Posterior pooled(const SizedCandidates& candidates, const ObjectProbabilities& objects,
                 const std::vector<Posterior>& posteriors) {
  const auto& symmetries = candidates[objects.best]->symmetries;
  Posterior pool = posteriors[objects.best];
  for (const std::size_t i : sizes_of(candidates, objects.best)) {
    if (i == objects.best) continue;
    const Posterior& other = posteriors[i];
    for (const Mode& mode : other.modes) add(mode, symmetries, pool.modes);
    pool.residual_set.insert(pool.residual_set.end(), other.residual_set.begin(),
                             other.residual_set.end());
    pool.credible_mass += other.credible_mass;
    pool.seconds += other.seconds;
  }
  std::ranges::stable_sort(pool.modes, std::greater{}, &Mode::weight);
  pool.status = status_of(pool.modes);
  return pool;
}

}  // namespace palpate::localization
