// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <string_view>

namespace palpate {

/// A seeded stream of random numbers: the same on every platform, independent of every other name.
///
/// Generator: xoshiro256++ (Blackman & Vigna 2019), its state filled by splitmix64.
class RandomStream {
 public:
  explicit RandomStream(std::uint64_t seed, std::string_view name = "");

  /// A stream of its own for a part of the work; does not advance this one.
  RandomStream fork(std::string_view name, std::uint64_t index = 0) const;

  std::uint64_t bits();
  double uniform();                         ///< in [0, 1)
  double uniform(double low, double high);  ///< in [low, high), high only by rounding
  double normal();                          ///< standard normal
  std::size_t index(std::size_t count);     ///< in 0..count-1; count > 0
  Eigen::Vector3d normal3();                ///< three independent standard normals
  Eigen::Vector3d unit_vector();            ///< uniform on the sphere
  Eigen::Matrix3d rotation();               ///< uniform on SO(3)

 private:
  std::uint64_t origin_;  // seed and name, hashed: where forks start
  std::uint64_t state_[4];
};

}  // namespace palpate
