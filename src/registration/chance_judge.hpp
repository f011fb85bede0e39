// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "pairing_rates.hpp"
#include "palpate/core/random.hpp"
#include "palpate/registration/chance.hpp"
#include "scorer.hpp"

namespace palpate::registration {

/// Expected number of poses as good as one by chance, as exactly as it matters.
class ChanceJudge {
 public:
  /// @param false_alarm  what the number will be held against
  ChanceJudge(const Scorer& scorer, double false_alarm, const RandomStream& random);

  /// As if all poses gathered as much as this one, which few do: chance hardly explains a pose that
  /// this does not explain.
  double quick(const Eigen::Isometry3d& T) const;

  /// With the rates at some random poses.
  double rough(const Eigen::Isometry3d& T);

  /// With the rates at many of them where the rough number is close to the false alarms.
  double exact(const Eigen::Isometry3d& T);

 private:
  /// Rates within one radius at random poses, as many as were asked for so far.
  struct Rates {
    double radius;
    PairingRates pairings;
    RandomStream random;
    std::vector<Eigen::Isometry3d> poses = {};
    std::vector<double> hits = {};
  };

  double judge(const Eigen::Isometry3d& T, int poses);
  Rates& rates_within(double radius);
  void extend(Rates& rates, int poses) const;
  bool same(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) const;

  const Scorer& scorer_;
  double false_alarm_;
  const RandomStream& random_;
  ChanceModel model_;           // but for the rates
  Eigen::Matrix3d spread_;      // second moment of the sources about their mean
  std::map<int, Rates> rates_;  // of steps of the radius
};

}  // namespace palpate::registration
