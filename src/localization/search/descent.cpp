// SPDX-License-Identifier: Apache-2.0
#include "localization/search/descent.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "palpate/core/angle.hpp"

namespace palpate::localization {
namespace {

constexpr PoseTolerance kSamePose{1.5 * kDegree, 0.002};  // two descents that ended together
constexpr std::size_t kMaxImaged = 4;                     // basins, the most probable
constexpr double kNegligible = 1e-5;                      // share of a basin that is left out
constexpr double kWiden = 2;  // of Laplace's covariances: the tails must be covered
constexpr double kNuggetAngle = 0.005, kNuggetStep = 0.0003;  // rad, m

/// The proposals of the least energy.
std::vector<SearchPose> best_proposals(const Proposal& proposal, const Energy& energy,
                                       const DescentOptions& options, RandomStream& random) {
  using Scored = std::pair<float, SearchPose>;
  const auto less = [](const Scored& a, const Scored& b) { return a.first < b.first; };
  std::vector<Scored> best;  // a heap, the worst on top
  for (int i = 0; i < options.proposals; ++i) {
    const bool full = static_cast<int>(best.size()) >= options.starts;
    const float bound = full ? best.front().first : kNoBound;
    const SearchPose pose = proposal.draw(random);
    const float e = energy(pose, bound);
    if (!(e < bound)) continue;
    if (full) {
      std::pop_heap(best.begin(), best.end(), less);
      best.pop_back();
    }
    best.emplace_back(e, pose);
    std::push_heap(best.begin(), best.end(), less);
  }
  std::vector<SearchPose> poses;
  for (const auto& [e, pose] : best) poses.push_back(pose);
  return poses;
}

PosePoint point_of(const SearchPose& pose) {
  return {Eigen::Quaterniond(pose.R.cast<double>()).normalized(), pose.t.cast<double>()};
}

std::vector<Basin> basins_of(std::vector<RefinedPose> refined,
                             const PoseFamily::Symmetries& symmetries) {
  std::sort(refined.begin(), refined.end(),
            [](const auto& a, const auto& b) { return a.log_weight > b.log_weight; });
  std::vector<Basin> basins;
  for (const RefinedPose& r : refined) {
    const PosePoint pose = point_of(r.pose);
    const auto same = std::find_if(basins.begin(), basins.end(), [&](const Basin& basin) {
      return PoseFamily(basin.pose).contains(pose, symmetries, kSamePose);
    });
    if (same != basins.end()) {
      ++same->starts;
    } else {
      basins.push_back({r, pose});
    }
  }
  return basins;
}

const Basin* holding(const std::vector<Basin>& basins, const SearchPose& pose,
                     const PoseFamily::Symmetries& symmetries) {
  const auto found = std::find_if(basins.begin(), basins.end(), [&](const Basin& basin) {
    return PoseFamily(basin.pose).contains(point_of(pose), symmetries, kSamePose);
  });
  return found == basins.end() ? nullptr : &*found;
}

/// Where the images of the most probable basins lead, as far as no other descent has ended there.
std::vector<RefinedPose> image_ends(const std::vector<Basin>& basins, const EnergyLadder& ladder,
                                    const PoseFamily::Symmetries& symmetries,
                                    const std::vector<Eigen::Matrix3d>& near_symmetries) {
  std::vector<RefinedPose> ends;
  for (std::size_t i = 0; i < std::min(kMaxImaged, basins.size()); ++i) {
    for (const Eigen::Matrix3d& turn : near_symmetries) {
      SearchPose image = basins[i].best.pose;
      image.R = image.R * turn.cast<float>();
      if (holding(basins, image, symmetries)) continue;
      const RefinedPose end = refined(image, ladder);
      if (!holding(basins, end.pose, symmetries)) ends.push_back(end);
    }
  }
  return ends;
}

}  // namespace

std::vector<Eigen::Matrix3d> half_turns(const geometry::KnownObject& object) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(object.mass_properties.inertia);
  std::vector<Eigen::Matrix3d> turns;
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d axis = axes.eigenvectors().col(k);
    turns.emplace_back(2 * axis * axis.transpose() - Eigen::Matrix3d::Identity());
  }
  return turns;
}

std::vector<Basin> find_basins(const Proposal& proposal,
                               const std::function<Energy(double)>& energy_at,
                               const PoseFamily::Symmetries& symmetries,
                               const DescentOptions& options, RandomStream& random) {
  const EnergyLadder ladder = energy_ladder(energy_at, options.first_scale);
  std::vector<RefinedPose> ends;
  for (const SearchPose& start : best_proposals(proposal, ladder.front().second, options, random)) {
    ends.push_back(refined(start, ladder));
  }
  const auto images =
      image_ends(basins_of(ends, symmetries), ladder, symmetries, options.near_symmetries);
  ends.insert(ends.end(), images.begin(), images.end());
  return basins_of(std::move(ends), symmetries);
}

std::vector<double> basin_shares(const std::vector<Basin>& basins) {
  std::vector<double> shares;
  double total = 0;
  for (const Basin& basin : basins) {
    shares.push_back(std::exp(basin.best.log_weight - basins.front().best.log_weight));
    total += shares.back();
  }
  for (double& share : shares) share /= total;
  return shares;
}

PosePrior mixture_about(const std::vector<Basin>& basins) {
  const std::vector<double> shares = basin_shares(basins);
  Vector6d nugget;
  nugget << Eigen::Vector3d::Constant(kNuggetAngle * kNuggetAngle),
      Eigen::Vector3d::Constant(kNuggetStep * kNuggetStep);
  PosePrior mixture;
  double total = 0;
  for (std::size_t i = 0; i < basins.size(); ++i) {
    if (shares[i] < kNegligible) continue;
    const Matrix6d covariance =
        kWiden * covariance_of(basins[i].best) + Matrix6d(nugget.asDiagonal());
    mixture.components.push_back({basins[i].pose.isometry(), std::sqrt(shares[i]), covariance});
    total += mixture.components.back().weight;
  }
  for (auto& component : mixture.components) component.weight /= total;
  return mixture;
}

}  // namespace palpate::localization
