// SPDX-License-Identifier: Apache-2.0
#include "tactile/normals/noise_meter.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::tactile {
namespace {

constexpr double kTrust = 5;  // samples that the first belief counts for
// Squares above this many variances count as much as that. Of normal noise, the sum over three
// axes exceeds it in 1.1 % and loses 0.5 % of its mean.
constexpr double kClip = 11.0 / 3;

}  // namespace

NoiseMeter::NoiseMeter(int axes, double sigma, double least, double memory)
    : axes_(axes), variance_(sigma * sigma), least_(least), memory_(memory), weight_(kTrust) {}

void NoiseMeter::add(const Eigen::Vector3d& value) {
  if (count_ >= 2) {
    const double square = (value - 2 * last_ + before_).squaredNorm() / (6 * axes_);
    weight_ = std::min(weight_ + 1, memory_);
    variance_ += (std::min(square, kClip * variance_) - variance_) / weight_;
  }
  before_ = last_;
  last_ = value;
  ++count_;
}

double NoiseMeter::sigma() const { return std::max(std::sqrt(variance_), least_); }

}  // namespace palpate::tactile
