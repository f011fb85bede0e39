// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <chrono>
#include <cmath>

#include "localization/likelihood/check_evidence.hpp"
#include "localization/likelihood/energy_maker.hpp"
#include "localization/likelihood/goodness_of_fit.hpp"
#include "localization/likelihood/surface_error.hpp"
#include "localization/search/descent.hpp"
#include "localization/search/pose_family.hpp"
#include "localization/search/proposal.hpp"
#include "palpate/core/angle.hpp"
#include "palpate/localization/localizer.hpp"

namespace palpate::localization {
namespace {

constexpr PoseTolerance kLoose{1.7 * kDegree,
                               0.0033};   // a standard deviation: a third of the tolerance
constexpr int kMinStarts = 3;             // that must have led to the best pose
constexpr double kNegligibleMode = 1e-4;  // weight of a pose not worth reporting

using Symmetries = PoseFamily::Symmetries;

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
  std::stable_sort(modes.begin(), modes.end(),
                   [](const Mode& m, const Mode& n) { return m.weight > n.weight; });
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
  const auto modes = modes_of(basins, symmetries, static_cast<std::size_t>(search.modes));
  const Basin& best = basins.front();
  const bool trusted = best.starts >= kMinStarts && tight(modes.front(), symmetries) &&
                       pose_probability(modes.front()) > options.certainty &&
                       !fit_is_rejected(model, evidence, best.best.pose, search.contact_offset);
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
