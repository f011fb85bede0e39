// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "palpate/core/random.hpp"
#include "registration/pair_columns.hpp"
#include "registration/thin_axes.hpp"

namespace palpate::registration {

/// first, first + step, .., count of them.
struct Strided {
  int first, step, count;
};

/// A pose at which one pair agrees.
struct ProposedPose {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  int source = 0;     ///< of the pair
  double weight = 1;  ///< how much rarer it is proposed than if the rest were left to chance
};

/// Which sources and targets, paired at random, agree at a pose.
///
/// Agreement is to lie in the same cube of a grid, and with normals to differ by a chord, which
/// together have the volume of the ball of that radius: a look-up a source instead of one a pair.
/// Of clouds that are large for the radius the cubes are too, and weigh less.
class PairingRates {
 public:
  /// @param columns  in noise bounds, at least one pair, to outlive this
  /// @param chord_bound  chord that counts as 1; 0: normals are not used
  /// @param radius  of the ball, in bounds
  /// @param axes  that propose() lays on one another
  PairingRates(const PairColumns& columns, double chord_bound, double radius,
               std::vector<ThinAxes> axes = {});

  /// A pose that makes one random pair agree and leaves the rest to chance; in half of the cases,
  /// if there are axes, one that lays them on one another, more or less. So few others do, and so
  /// much agrees where they do, that chance alone would seldom show it.
  ProposedPose propose(RandomStream& random) const;

  /// Appends how many targets each of some sources agrees with, where there are any.
  /// @param sources  first, first + step, .. (count of them, from the start again past the end)
  void agreements(const Eigen::Isometry3d& T, const Strided& sources,
                  std::vector<int>& counts) const;

  /// Volume of what counts as agreement, over that of the ball.
  double coarseness() const { return coarseness_; }

 private:
  Eigen::Matrix3d turn(const ThinAxes* aligned, RandomStream& random) const;
  double weight_of(const Eigen::Matrix3d& R) const;
  double roll(int source, const Eigen::Vector3d& normal, const ThinAxes* aligned,
              RandomStream& random, double& weight) const;
  int cell(const Eigen::Vector3f& p) const;
  int agreements_in(int cell, const Eigen::Matrix3f& R, int source) const;

  const PairColumns& columns_;
  float side_ = 1, per_side_ = 1, chord_squared_ = 0;  // 0: without normals
  double coarseness_ = 1;
  std::vector<ThinAxes> axes_;
  Eigen::Vector3f low_ = Eigen::Vector3f::Zero();
  Eigen::Array3i cells_ = Eigen::Array3i::Ones();
  std::vector<std::uint64_t> occupied_;  // bits of cells that hold targets: most do not
  std::vector<int> first_,
      targets_;  // of cell c: targets_[first_[c]] .. targets_[first_[c + 1] - 1]
};

/// Power of the mean that counts were drawn about, without bias: the mean of the products of so
/// many different ones (elementary symmetric polynomial), whatever else the counts vary by.
/// @param counts  those that are not 0
/// @param all  how many there are with those that are 0
double power_of_mean(const std::vector<int>& counts, int all, int power);

}  // namespace palpate::registration
