// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <limits>

#include "tactile/normals/s2_filter.hpp"

namespace palpate::tactile {

/// S2Filter whose estimates also know the samples of a while after: each is about the contact `lag`
/// earlier (NormalEstimate::time).
///
/// While the contact `lag` ago was none, the last before it is held. Where the finger may have left
/// the surface, what came after has no information on what was before.
///
/// Fixed-lag Rauch-Tung-Striebel smoothing of the tilt alone, its correlation with the rest of the
/// state left aside, through each tick's hypotheses by their weights.
class S2Smoother final : public NormalEstimator {
 public:
  /// @param options  lag: of the estimates, s
  /// @throws BadInput for options out of range
  explicit S2Smoother(const S2Options& options = {});
  NormalEstimate update(const FingerSample& sample) override;
  std::vector<NormalEstimate> take_late(bool ended = false) override;

 private:
  struct Tick {
    double time = 0;
    Eigen::Matrix3d R;
    Eigen::Matrix2d P;
    S2Filter::Step step;  // that led to it
  };

  NormalEstimate smoothed_first();
  void flush();

  S2Options options_;
  S2Filter filter_;
  std::deque<Tick> ticks_;
  std::vector<NormalEstimate> late_;  // of contacts that ended before their lag had passed
  double reported_ = -std::numeric_limits<double>::infinity();  // time of the last tick reported
};

}  // namespace palpate::tactile
