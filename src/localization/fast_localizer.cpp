// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <numeric>
#include <optional>
#include <utility>

#include "localization/likelihood/check_evidence.hpp"
#include "localization/likelihood/energy_maker.hpp"
#include "localization/likelihood/goodness_of_fit.hpp"
#include "localization/likelihood/surface_error.hpp"
#include "localization/likelihood/thinning.hpp"
#include "localization/search/descent.hpp"
#include "localization/search/importance_weights.hpp"
#include "localization/search/pose_family.hpp"
#include "localization/search/proposal.hpp"
#include "palpate/core/angle.hpp"
#include "palpate/core/se3.hpp"
#include "palpate/localization/localizer.hpp"

namespace palpate::localization {
namespace {

constexpr PoseTolerance kLoose{1.7 * kDegree,
                               0.0033};        // a standard deviation: a third of the tolerance
constexpr int kMinStarts = 3;                  // that must have led to the best pose
constexpr double kNegligibleMode = 1e-4;       // weight of a pose not worth reporting
constexpr int kDraws = 600, kMaxDraws = 2400;  // about the basins, that weigh the modes
constexpr double kMinEffective = 100;          // of these

using Symmetries = PoseFamily::Symmetries;

void sort_by_weight(std::vector<Mode>& modes) {
  std::ranges::stable_sort(modes, std::ranges::greater{}, &Mode::weight);
}

/// Basins within the tolerance of a pose are one mode.
std::vector<Mode> modes_of(const std::vector<Basin>& basins, const Symmetries& symmetries,
                           std::size_t most) {
  const std::vector<double> shares = basin_shares(basins);
  std::vector<Mode> modes;
  for (std::size_t i = 0; i < basins.size(); ++i) {
    const PosePoint& pose = basins[i].pose;
    const auto same = std::find_if(modes.begin(), modes.end(), [&](const Mode& mode) {
      return PoseFamily(PosePoint(mode.T_frame_object)).contains(pose, symmetries);
    });
    if (same != modes.end()) {
      same->weight += shares[i];
    } else if (modes.size() < most && shares[i] > kNegligibleMode) {
      modes.push_back({pose.isometry(), shares[i], covariance_of(basins[i].best), std::nullopt});
    }
  }
  sort_by_weight(modes);
  return modes;
}

/// Whether the pose is known, but for turns that the object's symmetry hides.
bool tight(const Mode& mode, const Symmetries& symmetries) {
  const auto widest = [](const Eigen::Matrix3d& part) {
    return std::sqrt(Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(part, Eigen::EigenvaluesOnly)
                         .eigenvalues()[2]);
  };
  const Eigen::Matrix3d& R = mode.T_frame_object.linear();
  const Eigen::Matrix3d seen = R * symmetries.seen_rotations() * R.transpose();
  return widest(seen * mode.covariance.topLeftCorner<3, 3>() * seen) < kLoose.rotation &&
         widest(mode.covariance.bottomRightCorner<3, 3>()) < kLoose.translation;
}

/// Poses about the basins, with their shares of the mass of the posterior there.
struct Draws {
  std::vector<PosePoint> poses;
  std::vector<double> shares;
};

/// Enough draws to know the mass of a mode; nothing if the basins do not tell where it is.
std::optional<Draws> draws_about(const std::vector<Basin>& basins, const Energy& energy,
                                 RandomStream random) {
  const auto about = mixture_proposal(mixture_about(basins));
  Draws draws;
  std::vector<double> log_weights;
  while (draws.poses.size() < kMaxDraws) {
    for (int i = 0; i < kDraws; ++i) {
      const SearchPose pose = about->draw(random);
      log_weights.push_back(static_cast<double>(about->energy(pose) - energy(pose)));
      draws.poses.emplace_back(Eigen::Quaterniond(pose.R.cast<double>()).normalized(),
                               pose.t.cast<double>());
    }
    draws.shares = relative_weights(log_weights);
    if (effective_sample_size(draws.shares) < kMinEffective) continue;
    const double total = std::accumulate(draws.shares.begin(), draws.shares.end(), 0.0);
    for (double& share : draws.shares) share /= total;
    return draws;
  }
  return std::nullopt;
}

/// Of the draws within the tolerance of a mode's pose, about it.
Matrix6d spread_about(const Mode& mode, const Draws& draws, const Symmetries& symmetries) {
  const PoseFamily ball{PosePoint(mode.T_frame_object)};
  Matrix6d sum = Matrix6d::Zero();
  double held = 0;
  for (std::size_t i = 0; i < draws.poses.size(); ++i) {
    if (!ball.contains(draws.poses[i], symmetries)) continue;
    const PosePoint image = ball.match(draws.poses[i], symmetries).image;
    Vector6d deviation;
    deviation << log_so3((image.q * ball.pose().q.conjugate()).toRotationMatrix()),
        image.t - ball.pose().t;
    sum += draws.shares[i] * deviation * deviation.transpose();
    held += draws.shares[i];
  }
  return sum / held;
}

/// Gives the modes the mass within the tolerance of their poses. Laplace's approximation takes all
/// of a basin to be there, and holds for the likeliest hypothesis about the noise alone.
void weigh(std::vector<Mode>& modes, Draws draws, const Symmetries& symmetries) {
  for (Mode& mode : modes) {
    const PoseFamily ball{PosePoint(mode.T_frame_object)};
    mode.weight = 0;
    for (std::size_t i = 0; i < draws.poses.size(); ++i) {
      if (!ball.contains(draws.poses[i], symmetries)) continue;
      mode.weight += std::exchange(draws.shares[i], 0);
    }
  }
  std::erase_if(modes, [](const Mode& mode) { return mode.weight <= kNegligibleMode; });
  sort_by_weight(modes);
}

/// The modes, if they are all that there can be: nothing otherwise.
std::vector<Mode> settled_modes(const geometry::ObjectModel& model, const Evidence& evidence,
                                RandomStream random, const LocalizerOptions& search,
                                const FastOptions& options) {
  const EnergyMaker energy_at(model, evidence, search);
  const auto proposal = make_proposal(model, evidence, search);
  const SymmetryGroup symmetries(model.object().symmetries);
  const auto basins = find_basins(
      *proposal, energy_at, symmetries,
      {options.proposals, options.starts, energy_at.first_scale(), half_turns(model.object())},
      random);
  if (basins.empty()) return {};
  auto modes = modes_of(basins, symmetries, static_cast<std::size_t>(search.modes));
  const Basin& best = basins.front();
  if (best.starts < kMinStarts || !tight(modes.front(), symmetries) ||
      pose_probability(modes.front()) <= options.certainty ||
      fit_is_rejected(model, evidence, best.best.pose, search.contact_offset)) {
    return {};
  }
  // Turns of a body of revolution about its axis would have to be drawn from all round.
  if (!symmetries.seen_rotations().isIdentity()) return modes;
  const auto draws = draws_about(basins, energy_at(1), random.fork("weighing"));
  if (!draws) return {};
  weigh(modes, *draws, symmetries);
  const bool trusted = !modes.empty() && pose_probability(modes.front()) > options.certainty;
  if (trusted) modes.front().covariance = spread_about(modes.front(), *draws, symmetries);
  return trusted ? modes : std::vector<Mode>{};
}

}  // namespace

Posterior localize_fast(const geometry::ObjectModel& model, const Evidence& evidence,
                        RandomStream random, const LocalizerOptions& options,
                        const FastOptions& fast) {
  const auto start = std::chrono::steady_clock::now();
  const auto elapsed = [start] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  check_evidence(model, evidence);
  Posterior posterior;
  if (!evidence.contacts.empty() && !evidence.prior) {
    posterior.modes = settled_modes(model, thinned(with_surface_error(evidence)),
                                    random.fork("fast"), options, fast);
    posterior.status = status_of(posterior.modes);
    if (!posterior.modes.empty()) posterior.credible_mass = 1 - posterior.residual_mass();
  }
  if (posterior.modes.empty()) posterior = localize(model, evidence, random, options);
  posterior.seconds = elapsed();
  return posterior;
}

}  // namespace palpate::localization
