// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <memory>
#include <vector>

#include "search_pose.hpp"

namespace palpate::localization {

inline constexpr float kNoBound = std::numeric_limits<float>::infinity();

/// One kind of evidence: its part of -ln p(evidence | pose), up to a constant.
class EvidenceTerm {
 public:
  virtual ~EvidenceTerm() = default;

  /// The energy of a pose. Above `bound` any value above it will do, so that terms may stop early.
  virtual float energy(const SearchPose& pose, float bound) const = 0;
};

/// The sum of all terms.
class Energy {
 public:
  void add(std::unique_ptr<EvidenceTerm> term) { terms_.push_back(std::move(term)); }

  float operator()(const SearchPose& pose, float bound = kNoBound) const {
    float sum = 0;
    for (const auto& term : terms_) {
      sum += term->energy(pose, bound - sum);
      if (sum > bound) break;
    }
    return sum;
  }

 private:
  std::vector<std::unique_ptr<EvidenceTerm>> terms_;
};

}  // namespace palpate::localization
