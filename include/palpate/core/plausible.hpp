// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string_view>

namespace palpate {

/// What a value that is read from outside may be at most: far beyond any robot hand, and small
/// enough that its square is exact to compute with. A finite value beyond is as wrong as nan.
inline constexpr double kMaxLength = 100;       ///< m, of a coordinate
inline constexpr double kMaxForce = 1e4;        ///< N, of a component
inline constexpr double kMaxTorque = 1e3;       ///< N m
inline constexpr double kMaxAngle = 1e3;        ///< rad, turns counted
inline constexpr double kMaxTime = 1e10;        ///< s; seconds since 1970 fit
inline constexpr double kMaxRadius = 1;         ///< m, of a part of a hand
inline constexpr double kMaxMass = 1e3;         ///< kg
inline constexpr double kMaxCoordinate = 1e12;  ///< of a shape, in whatever unit

/// The value. @throws BadInput, naming `what` and the value, unless low <= value <= high
double plausible(double value, double low, double high, std::string_view what);

/// @throws BadInput unless all of |v| <= most; nan is let through where `may_miss`
void check_plausible(const Eigen::Ref<const Eigen::VectorXd>& v, double most, std::string_view what,
                     bool may_miss = false);

/// The rotation. @throws BadInput unless R is one, within 1e-6
const Eigen::Matrix3d& rigid(const Eigen::Matrix3d& R, std::string_view what);

}  // namespace palpate
