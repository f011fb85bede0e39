// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <utility>
#include <vector>

#include "palpate/core/random.hpp"
#include "palpate/registration/chance.hpp"
#include "registration/pairing_rates.hpp"
#include "registration/scorer.hpp"

namespace palpate::registration {

/// Below this the quick judgement needs no other.
inline constexpr double kClearAtOnce = 1e-8;

/// Expected number of poses as good as one by chance, as exactly as it matters.
class ChanceJudge {
 public:
  /// @param false_alarm  what the number will be held against
  ChanceJudge(const Scorer& scorer, double false_alarm, const RandomStream& random);

  /// As if all poses gathered as much as this one, which few do: chance hardly explains a pose that
  /// this does not explain.
  double quick(const Eigen::Isometry3d& T) const;

  /// Random poses whose rates are looked up, and sources at each.
  struct Effort {
    int poses, sources;
  };
  static constexpr Effort kRough{64, 128}, kMedium{128, 512};

  /// With the rates at some random poses.
  double judge(const Eigen::Isometry3d& T, Effort effort);

  /// The quick number if that is clear; with the rates at many poses where the rough one is close
  /// to the false alarms.
  double exact(const Eigen::Isometry3d& T);

 private:
  /// Rates within one radius at random poses, as many as were asked for so far.
  struct Rates {
    double radius;
    int sources;  // looked up at a pose
    PairingRates pairings;
    RandomStream random;
    std::vector<Eigen::Isometry3d> poses = {};
    std::vector<std::vector<int>> counts = {};  // of each, as PairingRates::agreements()
  };

  Rates& rates_within(double radius, int sources);
  void extend(Rates& rates, int poses) const;
  double power_mean(const Rates& rates, const Eigen::Isometry3d& T, int power) const;
  bool same(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) const;

  const Scorer& scorer_;
  double false_alarm_;
  const RandomStream& random_;
  ChanceModel model_;                           // but for the rates
  Eigen::Matrix3d spread_;                      // second moment of the sources about their mean
  std::map<std::pair<int, int>, Rates> rates_;  // of steps of the radius and sources
};

}  // namespace palpate::registration
