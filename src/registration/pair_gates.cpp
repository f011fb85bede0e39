// SPDX-License-Identifier: Apache-2.0
#include "registration/pair_gates.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

namespace palpate::registration {
namespace {

/// joined[j], for all j of the padded columns, = whether |s_i s_j| and |t_i t_j| differ by at most
/// g and the first is above g. Without square roots: (A - B)^2 <= g^2 iff A^2 + B^2 <= g^2 or (A^2
/// - B^2)^2
/// <= 2 g^2 (A^2 + B^2) - g^4.
PALPATE_WIDE void compare_lengths(const PairColumns& c, int i, int padded, float g,
                                  std::uint8_t* __restrict joined) {
  const float g2 = g * g, g4 = g2 * g2;
  const float *ax = c.s[0].data(), *ay = c.s[1].data(), *az = c.s[2].data();
  const float *bx = c.t[0].data(), *by = c.t[1].data(), *bz = c.t[2].data();
  const float sx = ax[i], sy = ay[i], sz = az[i], tx = bx[i], ty = by[i], tz = bz[i];
  for (int j = 0; j < padded; ++j) {
    const float dx = ax[j] - sx, dy = ay[j] - sy, dz = az[j] - sz;
    const float ex = bx[j] - tx, ey = by[j] - ty, ez = bz[j] - tz;
    const float a = dx * dx + dy * dy + dz * dz, b = ex * ex + ey * ey + ez * ez;
    const float difference = a - b, slack = 2 * g2 * (a + b) - g4 - difference * difference;
    joined[j] = static_cast<std::uint8_t>((slack >= 0) & (a > g2));
  }
}

/// Narrows joined[j] to normals whose angle is the same in both frames.
/// @param cosine  of the tolerance
PALPATE_WIDE void compare_normals(const PairColumns& c, int i, int padded, float cosine,
                                  std::uint8_t* __restrict joined) {
  const float *ax = c.n[0].data(), *ay = c.n[1].data(), *az = c.n[2].data();
  const float *bx = c.m[0].data(), *by = c.m[1].data(), *bz = c.m[2].data();
  const float nx = ax[i], ny = ay[i], nz = az[i], mx = bx[i], my = by[i], mz = bz[i];
  for (int j = 0; j < padded; ++j) {
    const float a = nx * ax[j] + ny * ay[j] + nz * az[j];
    const float b = mx * bx[j] + my * by[j] + mz * bz[j];
    const float r = cosine - a * b, sines = (1 - a * a) * (1 - b * b);
    joined[j] &= static_cast<std::uint8_t>((r <= 0) | (sines >= r * r));
  }
}

/// Eight bytes of 0 or 1 to eight bits.
std::uint64_t pack(const std::uint8_t* bytes) {
  std::uint64_t word;
  std::memcpy(&word, bytes, sizeof(word));
  return word * 0x0102040810204080u >> 56;
}

/// Whether the angles between two unit vectors of each frame agree: |acos(a) - acos(b)| <= x for
/// cosines a, b times lengths whose squares are given, without square roots.
bool angles_agree(float a, float b, float squares_a, float squares_b, float cosine_and_lengths) {
  const float r = cosine_and_lengths - a * b;
  return r <= 0 || (squares_a - a * a) * (squares_b - b * b) >= r * r;
}

/// Not above cos(x), and close to it up to pi / 2.
float low_cosine(float x) {
  const float x2 = x * x;
  return 1 - x2 / 2 + x2 * x2 / 24 - x2 * x2 * x2 / 720;
}

}  // namespace

PairGates::PairGates(const PairColumns& columns, double length_tolerance, double normal_noise_deg)
    : columns_(columns),
      length_tolerance_(static_cast<float>(length_tolerance)),
      normal_noise_(static_cast<float>(normal_noise_deg * std::numbers::pi / 180)) {}

void PairGates::row(int i, std::uint64_t* bits) {
  const int padded = words() * kWordBits;
  joined_.resize(static_cast<std::size_t>(padded));
  compare_lengths(columns_, i, padded, length_tolerance_, joined_.data());
  if (normal_noise_ > 0) {
    // 3.6 standard deviations; an angle of two noisy normals varies sqrt 2 times as much.
    const float tolerance = 3.6F * 1.414F * normal_noise_;
    if (tolerance < std::numbers::pi_v<float>) {
      compare_normals(columns_, i, padded, std::cos(tolerance), joined_.data());
    }
  }
  for (int w = 0; w < words(); ++w) {
    std::uint64_t word = 0;
    for (int k = 0; k < 8; ++k) word |= pack(joined_.data() + w * kWordBits + 8 * k) << 8 * k;
    bits[w] = word;
  }
  if (normal_noise_ > 0) narrow_by_lines(i, bits);
}

/// Drops those where an angle between one of the normals and the line that joins the points differs
/// in the frames.
void PairGates::narrow_by_lines(int i, std::uint64_t* bits) const {
  const Eigen::Vector3f s = at(columns_.s, i), t = at(columns_.t, i), n = at(columns_.n, i),
                        m = at(columns_.m, i);
  for_each_bit(bits, words(), [&](int j) {
    const Eigen::Vector3f d = at(columns_.s, j) - s, e = at(columns_.t, j) - t;
    const float d2 = d.squaredNorm(), e2 = e.squaredNorm(), length = std::sqrt(d2);
    // The line's own direction errs by 4.2 standard deviations of a position, 1/4 bound each.
    const float limit = low_cosine(3.6F * normal_noise_ + 1.05F / length) * length * std::sqrt(e2);
    const bool agree =
        angles_agree(n.dot(d), m.dot(e), d2, e2, limit) &&
        angles_agree(at(columns_.n, j).dot(d), at(columns_.m, j).dot(e), d2, e2, limit);
    if (!agree) bits[j / kWordBits] &= ~(std::uint64_t{1} << (j % kWordBits));
  });
}

}  // namespace palpate::registration
