// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "palpate/core/random.hpp"
#include "registration/false_alarms.hpp"
#include "registration/pairing_rates.hpp"
#include "registration/scorer.hpp"

namespace palpate::registration {

/// Below this the quick number needs no other.
inline constexpr double kClearAtOnce = 1e-8;

/// Within how many bounds in both frames pairs may depend on one another, and within how many
/// copies are looked for: copies with a spread of half a bound an axis are mostly within two;
/// farther out independent pairs have neighbours, too.
struct Dependence {
  double reach = 4, copies = 2;
};

/// Expected number of poses as good as one by chance, as exactly as it matters.
class FalseAlarmTest {
 public:
  /// @param max_false_alarms  what the number will be held against
  /// @param dependence  between pairs
  FalseAlarmTest(const Scorer& scorer, double max_false_alarms, const Dependence& dependence,
                 const RandomStream& random);

  /// As if all poses gathered as much as this one, which few do: chance hardly explains a pose that
  /// this does not explain.
  double quick(const Eigen::Isometry3d& T);

  /// Random poses whose rates are looked up, and sources at each.
  struct Effort {
    int poses, sources;
  };
  static constexpr Effort kRough{64, 128}, kMedium{128, 512};

  /// Below `enough_below` times the tolerated number the effort decides.
  struct Step {
    Effort effort;
    double enough_below;
  };

  /// With the rates at some random poses; at fewer, where the number is above `enough` whatever the
  /// others gather.
  double estimate(const Eigen::Isometry3d& T, Effort effort,
                  double enough = std::numeric_limits<double>::infinity());

  /// How many of the inliers of T are wrong pairs that agree by accident: as many as agree where
  /// the same points are paired otherwise.
  double false_inliers(const Eigen::Isometry3d& T) const;

  /// The quick number if that is clear; with the rates at many poses where the rough one is close
  /// to the false alarms. Where pairs have copies nearby, as matches of overlapping features do,
  /// normals are no evidence beside positions: features are made of them, and patches of two
  /// surfaces that lie on one another agree in both. The larger number of the two then stands.
  double exact(const Eigen::Isometry3d& T);

 private:
  /// Rates within one radius at random poses, as many as were asked for so far.
  struct Rates {
    double radius;
    int sources;  // looked up at a pose
    PairingRates pairings;
    RandomStream random;
    std::vector<ProposedPose> poses = {};
    std::vector<std::vector<int>> counts = {};  // of each, as PairingRates::agreements()
  };

  /// Sums over poses: of the agreements, of their powers, and of the squares of these.
  struct Powers {
    double agreements = 0, sum = 0, squares = 0;
  };

  /// Inliers that speak for a pose each by itself, and how many pairs stand for one of them.
  struct Evidence {
    Score score;
    double copies = 1;
  };

  /// What the inliers of T are worth: where the other pairs have copies nearby, as jittered ones or
  /// matches of overlapping features do, inliers near one another count once.
  Evidence evidence(const Eigen::Isometry3d& T);
  double copies(const Eigen::Isometry3d& T);
  double copies_among_others(const Eigen::Isometry3d& T) const;
  double estimate_closely(const Eigen::Isometry3d& T);
  double estimate_in_steps(const Eigen::Isometry3d& T, std::span<const Step> steps);
  double expected(BackgroundModel background, const Score& score, double copies) const;
  double crowding(const Eigen::Isometry3d& T, const Score& score);
  BackgroundModel all_alike(const Eigen::Isometry3d& T) const;
  double expected_on_grid(const BackgroundModel& background, Score score, double copies) const;
  bool is_on_grid(double radius) const;
  double radius_of(const Score& score) const;
  const std::vector<ThinAxes>& axes();
  Rates& rates_within(double radius, int sources);
  void extend(Rates& rates, int poses) const;
  Powers powers_of(const Rates& rates, const Eigen::Isometry3d& T, int power) const;
  double power_mean(const Rates& rates, const Eigen::Isometry3d& T, int power) const;
  double min_power_mean(const Rates& rates, const Eigen::Isometry3d& T, int power, int poses) const;
  bool same(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) const;

  const Scorer& scorer_;
  double max_false_alarms_;
  Dependence dependence_;
  const RandomStream& random_;
  std::optional<double> copies_;                // of a pair, itself included, once it was asked for
  std::optional<std::vector<ThinAxes>> axes_;   // once they were asked for
  BackgroundModel model_;                       // but for the rates
  Eigen::Matrix3d spread_;                      // second moment of the sources about their mean
  std::map<std::pair<int, int>, Rates> rates_;  // of steps of the radius and sources
};

}  // namespace palpate::registration
