// SPDX-License-Identifier: Apache-2.0
#include "palpate/core/random.hpp"

#include <bit>
#include <cmath>
#include <numbers>

#include "palpate/core/fnv1a.hpp"

namespace palpate {
namespace {

std::uint64_t splitmix64(std::uint64_t& x) {
  std::uint64_t z = (x += 0x9e3779b97f4a7c15ull);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
  return z ^ (z >> 31);
}

std::uint64_t mixed(std::uint64_t x) { return splitmix64(x); }

}  // namespace

RandomStream::RandomStream(std::uint64_t seed, std::string_view name)
    : origin_(mixed(seed) ^ fnv1a(name)) {
  std::uint64_t x = origin_;
  for (auto& word : state_) word = splitmix64(x);
}

RandomStream RandomStream::fork(std::string_view name, std::uint64_t index) const {
  return RandomStream(mixed(origin_) + index * 0x9e3779b97f4a7c15ull, name);
}

std::uint64_t RandomStream::bits() {
  const std::uint64_t result = std::rotl(state_[0] + state_[3], 23) + state_[0];
  const std::uint64_t t = state_[1] << 17;
  state_[2] ^= state_[0];
  state_[3] ^= state_[1];
  state_[1] ^= state_[2];
  state_[0] ^= state_[3];
  state_[2] ^= t;
  state_[3] = std::rotl(state_[3], 45);
  return result;
}

double RandomStream::uniform() { return static_cast<double>(bits() >> 11) * 0x1.0p-53; }

double RandomStream::uniform(double low, double high) { return low + (high - low) * uniform(); }

double RandomStream::normal() {
  // Box-Muller; 1 - u keeps the logarithm finite.
  const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
  return radius * std::cos(2.0 * std::numbers::pi * uniform());
}

std::size_t RandomStream::index(std::size_t count) {
  return static_cast<std::size_t>(uniform() * static_cast<double>(count));
}

Eigen::Vector3d RandomStream::normal3() {
  const double x = normal(), y = normal(), z = normal();
  return {x, y, z};
}

Eigen::Vector3d RandomStream::unit_vector() {
  const double z = uniform(-1.0, 1.0);
  const double angle = uniform(-std::numbers::pi, std::numbers::pi);
  const double radius = std::sqrt(1.0 - z * z);
  return {radius * std::cos(angle), radius * std::sin(angle), z};
}

Eigen::Matrix3d RandomStream::rotation() {
  // Shoemake, "Uniform random rotations", Graphics Gems III, 1992.
  const double u = uniform();
  const double a = 2 * std::numbers::pi * uniform(), b = 2 * std::numbers::pi * uniform();
  const double r = std::sqrt(1 - u), s = std::sqrt(u);
  return Eigen::Quaterniond(s * std::cos(b), r * std::sin(a), r * std::cos(a), s * std::sin(b))
      .toRotationMatrix();
}

}  // namespace palpate
