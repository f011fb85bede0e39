// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <numbers>

namespace palpate::registration {

/// How closely wrong correspondences agree with the poses that there are: sources and targets
/// paired at random. Lengths are in noise bounds.
struct BackgroundModel {
  int dimensions = 3;  ///< of one residual: 3 for positions, 5 with normals
  double pairs = 0;    ///< correspondences
  /// What one pair leaves free of the rotation: 8 pi^2, all of SO(3); with normals that agree to a
  /// chord c, 2 pi c^2.
  double orientations = 8 * std::numbers::pi * std::numbers::pi;
  /// The information of a pair on the rotation, on average by its position (inertia of the sources
  /// about their mean, a share 1 / pairs each) and by its normal.
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d normal_information = Eigen::Matrix3d::Zero();
  double radius = 1;  ///< within which the rate counts residuals, d-dimensional
  /// Pairs of all that agree to within the radius, on average over the poses at which one random
  /// pair does: the power mean of that exponent, one less than there are inliers.
  double rate = 0;
};

/// Residuals that agree more closely count as if they agreed to within this: how many pairs do by
/// chance is looked up no closer.
inline constexpr double kMinMatchingRadius = 1e-3;

/// Radius of the ball whose uniform residuals have the mean square that k residuals with a sum of
/// squares S have after a pose was fitted to them; at most 1.
double matching_radius(int dimensions, double squares, int count);

/// The opposite: that sum of squares.
double matching_squares(int dimensions, double radius, int count);

/// Expected number of poses about which chance gathers such a consensus (an a-contrario test in the
/// sense of Desolneux, Moisan & Morel 2000; Moisan & Stival 2004, with the residuals instead of
/// their largest).
///
/// With residuals of wrong pairs of the density rate(T) / V_d(radius) at pose T, the sets of k
/// whose squares about their best pose sum up to at most S number (a tube about the poses, Weyl)
///
///   1 / k! V_d(radius)^-k  integral of rate(T)^k sqrt(det H_k) dT over SE(3)  V_{d k - 6}(sqrt S)
///
/// where V_n(r) is the volume of a ball in n dimensions, and H_k the information of k pairs. Poses
/// at which a random pair agrees come with the density rate(T), which makes the integral
/// pairs * orientations * V_d(radius) * mean of rate^(k - 1) over them.
/// @param squares  S, sum of the squared residuals of the inliers, d-dimensional
/// @param count  k, inliers; up to three are always expected (infinitely often), and any number of
///        an inertia that is not finite
double number_of_false_alarms(const BackgroundModel& model, double squares, int count);

/// An upper bound where the points are on a grid, whose poses meet points exactly or not at all:
///
///   (n)_3^2 / (k)_3  P(X >= k),  X ~ Poisson(max(1, rate)),  (n)_3 = n (n - 1) (n - 2).
///
/// A pose that brings k of n points onto points is that of (k)_3 pairs of triples, of which there
/// are (n)_3^2; at such a pose, so many of the points' other pairings agree.
/// @param rate  pairs of all that agree at the pose if the same points are paired otherwise
double grid_false_alarms(double pairs, double rate, int count);

/// Probability that of more + fewer pairs, each of which agrees with one of two poses alone and
/// with either alike, at least `more` agree with the first: the sign test (Dixon & Mood 1946) by
/// Chernoff's bound, 1 unless more > fewer.
double sign_test(int more, int fewer);

}  // namespace palpate::registration
