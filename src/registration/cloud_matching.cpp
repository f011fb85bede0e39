// SPDX-License-Identifier: Apache-2.0
#include "registration/cloud_matching.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "registration/cloud_candidates.hpp"
#include "registration/cloud_refinement.hpp"
#include "registration/neighbour_rounds.hpp"

namespace palpate::registration {
namespace {

using geometry::PointCloud;

FeatureCloud turned_inside_out(FeatureCloud described) {
  for (auto& n : described.cloud.normals) n = -n;
  described.features = geometry::turned_inside_out(std::move(described.features));
  return described;
}

/// Every stride-th point.
FeatureCloud some_of(const FeatureCloud& described, std::size_t stride) {
  std::vector<int> kept;
  for (std::size_t i = 0; i < described.cloud.size(); i += stride) {
    kept.push_back(static_cast<int>(i));
  }
  FeatureCloud some = {geometry::subset(described.cloud, kept),
                       described.features(Eigen::all, kept)};
  some.estimated_normals = described.estimated_normals;
  some.is_fpfh = described.is_fpfh;
  return some;
}

FeatureCloud mirrored(FeatureCloud described) {
  described.cloud = mirror_image(std::move(described.cloud));
  described.features = geometry::mirrored(std::move(described.features));
  return described;
}

/// Pose from the matches of features. Estimated normals may all point inward, as those of a part of
/// a surface can. As matches of normals of opposite signs have led to wrong poses with 5e-9 false
/// alarms, they are also tried the other way unless the first answer is far clearer: the better
/// stays.
/// @param clear  false alarms below which nothing else is tried
/// @return what else the matches of features may mean, where the answer is not far clearer: which
///         of them fits is left to the dense clouds
Alternatives match_features(FeatureCloud from, const FeatureCloud& to, double clear,
                            const CloudOptions& options, CloudRegistration& registration) {
  constexpr std::size_t kMirrorStride = 4;  // a pose to start from is all that is needed
  const RegistrationOptions search = feature_search(options, registration);
  FeatureCloud kept;
  Alternatives other;
  const bool fpfh = from.is_fpfh && to.is_fpfh;
  const int tries = fpfh && (from.estimated_normals || to.estimated_normals) ? 2 : 1;
  for (int attempt = 0; attempt < tries; ++attempt) {
    if (attempt > 0) from = turned_inside_out(std::move(from));
    Correspondences matches = matched_features(from, to, options.threads);
    RegistrationResult found = register_correspondences(matches, search);
    if (found.T_target_source) other.poses.push_back(*found.T_target_source);
    if (found.runner_up) other.poses.push_back(found.runner_up->T_target_source);
    if (attempt == 0 || found.false_alarms < registration.result.false_alarms) {
      registration.feature_matches = matches.size();
      registration.correspondences = std::move(matches);
      registration.result = std::move(found);
      kept = from;
    }
    if (registration.result.false_alarms < clear) {
      other.clear = true;
      return other;
    }
  }
  if (!fpfh || !search.turns().all()) return other;
  const FeatureCloud some = mirrored(some_of(kept, kMirrorStride));
  const Correspondences matches = matched_features(some, to, options.threads);
  other.T_mirrored = register_correspondences(matches, search).T_target_source;
  return other;
}

/// Of what features may mean, and of turns about the source's axes, which are the finer the less
/// clear the answer is: those of a turned cup, upside down and its handle elsewhere, take two.
std::optional<BetterFit> best_alternative(const PointCloud& source, const PointCloud& target,
                                          const Alternatives& other, const CloudOptions& options,
                                          const CloudRegistration& registration) {
  constexpr double kDoubtful = 1e-10;
  const auto& result = registration.result;
  const bool doubtful = !(result.false_alarms < kDoubtful);
  std::vector<Eigen::Isometry3d> poses = other.poses;
  const auto append = [&](const std::vector<Eigen::Isometry3d>& more) {
    poses.insert(poses.end(), more.begin(), more.end());
  };
  if (other.T_mirrored) append(unmirrored(source, *other.T_mirrored));
  const bool turns = options.registration.turns().all();
  if (turns) append(with_axes_aligned(source, target));
  auto T = result.T_target_source;
  if (other.clear) {
    if (!T) return std::nullopt;  // a reflection is clear
    std::erase_if(poses, [&](const auto& pose) { return pose.isApprox(*T, 0); });
    if (turns) append(turned_about_axes(source, *T, 2));
    const auto kept = promising(source, target, *T, poses, registration.noise_bound, options);
    if (kept) poses = *kept;
    if (poses.empty()) return std::nullopt;
    return better_fitting(source, target, T, poses, registration.noise_bound, options);
  }
  std::optional<BetterFit> best;
  for (int pass = 0; pass < (doubtful ? 2 : 1); ++pass) {
    if (T && turns) append(turned_about_axes(source, *T, doubtful ? 12 : 2));
    const auto next = better_fitting(source, target, T, poses, registration.noise_bound, options);
    if (!next) break;
    best = {next->T_target_source, std::max(next->deviations, best ? best->deviations : 0)};
    T = best->T_target_source;
    poses.clear();
  }
  return best;
}

/// Of an answer that gave way to a better one: itself, or, where both are nearly the same, its own.
std::optional<RunnerUp> runner_up_of(const RegistrationResult& better,
                                     const RegistrationResult& before) {
  std::vector<int> others;
  std::ranges::set_difference(before.inliers, better.inliers, std::back_inserter(others));
  if (2 * others.size() < before.inliers.size()) return before.runner_up;
  return RunnerUp{static_cast<int>(others.size()), *before.T_target_source, before.false_alarms};
}

}  // namespace

RegistrationOptions feature_search(const CloudOptions& options,
                                   const CloudRegistration& registration) {
  RegistrationOptions search = options.registration;
  search.noise_bound = registration.noise_bound;
  search.primitive = Primitive::kPoint;
  search.robust_bound.max_nodes = 0;  // once, of the matches that are left in the end
  // Neighbours whose features were made of the same points match alike, wherever that is.
  search.support_radius =
      std::max(search.support_radius, options.features.feature_radius_voxels * registration.voxel);
  return search;
}

Alternatives match_prepared(const PreparedCloud& from, const PreparedCloud& to,
                            const CloudOptions& options, CloudRegistration& registration) {
  // Wrong poses have mostly had 3e-13 and more, but those of a bracket upside down 2e-41.
  constexpr double kClearFalseAlarms = 1e-24;
  Alternatives other =
      match_features(from.described, to.described, kClearFalseAlarms, options, registration);
  const auto& T = registration.result.T_target_source;
  if (!other.clear || !T || options.features.refinements == 0 ||
      !options.registration.turns().all() || !from.described.is_fpfh) {
    return other;
  }
  const auto reflections = promising(from.dense, to.dense, *T, reflected(from.dense, *T),
                                     registration.noise_bound, options);
  if (reflections && reflections->empty()) return other;
  return match_features(from.described, to.described, 0, options, registration);
}

std::optional<Eigen::Isometry3d> prefer_better_fit(const PreparedCloud& from,
                                                   const PreparedCloud& to,
                                                   const Alternatives& other,
                                                   const CloudOptions& options,
                                                   CloudRegistration& registration) {
  constexpr double kFarBetter = 3;
  RegistrationResult& result = registration.result;
  const auto fit = best_alternative(from.dense, to.dense, other, options, registration);
  if (!fit) return std::nullopt;
  RegistrationOptions search = feature_search(options, registration);
  search.initial = fit->T_target_source;
  search.initial_reach = 1;
  RegistrationResult better = register_correspondences(registration.correspondences, search);
  if (!better.T_target_source && fit->deviations < kFarBetter) return fit->T_target_source;
  if (better.T_target_source && result.T_target_source) {
    better.runner_up = runner_up_of(better, result);
  }
  result = std::move(better);
  return fit->T_target_source;
}

}  // namespace palpate::registration
