// SPDX-License-Identifier: Apache-2.0
#include "palpate/registration/consistency_graph.hpp"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <numbers>
#include <utility>

#include "palpate/core/error.hpp"

namespace palpate::registration {
namespace {

constexpr int kWordBits = 64;

/// Coordinates one axis after the other, which compilers vectorise, in units of the noise bound.
struct Coordinates {
  std::vector<float> x, y, z;

  Coordinates(const std::vector<Eigen::Vector3d>& points, const Eigen::Vector3d& origin,
              double unit) {
    for (const auto& p : points) {
      const Eigen::Vector3f q = ((p - origin) / unit).cast<float>();
      x.push_back(q[0]);
      y.push_back(q[1]);
      z.push_back(q[2]);
    }
  }
  Eigen::Vector3f at(std::size_t i) const { return {x[i], y[i], z[i]}; }
};

/// joined[j] = whether |s_i s_j| and |t_i t_j| differ by at most g and the first is above g.
/// Without square roots: (A - B)^2 <= g^2 iff A^2 + B^2 <= g^2 or (A^2 - B^2)^2 <= 2 g^2 (A^2 +
/// B^2) - g^4.
void compare_lengths(const Coordinates& s, const Coordinates& t, std::size_t i, float g,
                     std::uint8_t* __restrict joined) {
  const float g2 = g * g, g4 = g2 * g2;
  const float sx = s.x[i], sy = s.y[i], sz = s.z[i], tx = t.x[i], ty = t.y[i], tz = t.z[i];
  const float *ax = s.x.data(), *ay = s.y.data(), *az = s.z.data();
  const float *bx = t.x.data(), *by = t.y.data(), *bz = t.z.data();
  for (std::size_t j = i + 1; j < s.x.size(); ++j) {
    const float dx = ax[j] - sx, dy = ay[j] - sy, dz = az[j] - sz;
    const float ex = bx[j] - tx, ey = by[j] - ty, ez = bz[j] - tz;
    const float a = dx * dx + dy * dy + dz * dz, b = ex * ex + ey * ey + ez * ez;
    const float difference = a - b, slack = 2 * g2 * (a + b) - g4 - difference * difference;
    joined[j] = static_cast<std::uint8_t>((slack >= 0) & (a > g2));
  }
}

/// Eight bytes of 0 or 1 to eight bits.
std::uint64_t pack(const std::uint8_t* bytes) {
  std::uint64_t word;
  std::memcpy(&word, bytes, sizeof(word));
  return word * 0x0102040810204080u >> 56;
}

/// Normals of both frames with the tolerances of their angles.
class AngleTest {
 public:
  AngleTest(const Correspondences& c, const Coordinates& s, const Coordinates& t, double noise_deg)
      : s_(s),
        t_(t),
        n_(c.source_normals, Eigen::Vector3d::Zero(), 1),
        m_(c.target_normals, Eigen::Vector3d::Zero(), 1),
        noise_(static_cast<float>(noise_deg * std::numbers::pi / 180)) {}

  bool operator()(std::size_t i, std::size_t j) const {
    const Eigen::Vector3f n1 = n_.at(i), n2 = n_.at(j), m1 = m_.at(i), m2 = m_.at(j);
    // 3.6 standard deviations; an angle of two noisy normals varies sqrt 2 times as much.
    if (!close(n1.dot(n2), m1.dot(m2), 3.6F * 1.414F * noise_)) return false;
    const Eigen::Vector3f d = s_.at(j) - s_.at(i), e = t_.at(j) - t_.at(i);
    const float length = d.norm(), other = e.norm();
    // The line's own direction errs by 4.2 standard deviations of a position, 1/4 bound each.
    const float tolerance = 3.6F * noise_ + 1.05F / length;
    return close(n1.dot(d) / length, m1.dot(e) / other, tolerance) &&
           close(n2.dot(d) / length, m2.dot(e) / other, tolerance);
  }

 private:
  /// |acos(a) - acos(b)| <= tolerance
  static bool close(float a, float b, float tolerance) {
    if (tolerance >= std::numbers::pi_v<float>) return true;
    const float sines = (1 - a * a) * (1 - b * b);
    return a * b + std::sqrt(std::max(sines, 0.0F)) >= std::cos(tolerance);
  }

  const Coordinates &s_, &t_;
  Coordinates n_, m_;
  float noise_;
};

/// Calls visit(bit) for every bit that is set, lowest first.
template <class Visit>
void for_each_bit(const std::uint64_t* words, int count, const Visit& visit) {
  for (int w = 0; w < count; ++w) {
    for (std::uint64_t rest = words[w]; rest != 0; rest &= rest - 1) {
      visit(w * kWordBits + std::countr_zero(rest));
    }
  }
}

/// Bits set in both. Sums bytes over at most 31 words at a time, which cannot overflow: without a
/// machine instruction this is several times faster than counting word by word.
int common_bits(const std::uint64_t* a, const std::uint64_t* b, int words) {
  constexpr std::uint64_t k1 = 0x5555555555555555, k2 = 0x3333333333333333, k4 = 0x0f0f0f0f0f0f0f0f,
                          k8 = 0x00ff00ff00ff00ff;
  int total = 0;
  for (int start = 0; start < words; start += 31) {
    const int end = std::min(words, start + 31);
    std::uint64_t bytes = 0;
    for (int w = start; w < end; ++w) {
      std::uint64_t x = a[w] & b[w];
      x -= x >> 1 & k1;
      x = (x & k2) + (x >> 2 & k2);
      bytes += (x + (x >> 4)) & k4;
    }
    const std::uint64_t pairs = (bytes & k8) + (bytes >> 8 & k8);
    total += static_cast<int>(pairs * 0x0001000100010001 >> 48);
  }
  return total;
}

}  // namespace

ConsistencyGraph::ConsistencyGraph(const Correspondences& correspondences,
                                   const ConsistencyOptions& options) {
  check(correspondences);
  const double unit = options.noise_bound;
  if (!(unit > 0) || !(options.length_tolerance > 0)) {
    throw BadInput(fmt::format("noise bound {} m with tolerance {} is not positive", unit,
                               options.length_tolerance));
  }
  size_ = static_cast<int>(correspondences.size());
  words_ = (size_ + kWordBits - 1) / kWordBits;
  bits_.assign(static_cast<std::size_t>(size_) * static_cast<std::size_t>(words_), 0);
  degrees_.assign(correspondences.size(), 0);
  if (size_ == 0) return;
  const Coordinates s(correspondences.source, correspondences.source[0], unit);
  const Coordinates t(correspondences.target, correspondences.target[0], unit);
  const bool angles = options.normal_noise_deg > 0 && correspondences.has_normals();
  const AngleTest angle_test(correspondences, s, t, options.normal_noise_deg);
  const auto tolerance = static_cast<float>(options.length_tolerance);
  std::vector<std::uint8_t> joined(static_cast<std::size_t>(words_) * kWordBits);
  std::vector<std::uint64_t> later(static_cast<std::size_t>(words_));
  for (int i = 0; i < size_; ++i) {
    const auto index = static_cast<std::size_t>(i);
    compare_lengths(s, t, index, tolerance, joined.data());
    joined[index] = 0;
    const int first = i / kWordBits;
    for (int w = first; w < words_; ++w) {
      std::uint64_t word = 0;
      for (int k = 0; k < 8; ++k) word |= pack(joined.data() + w * kWordBits + 8 * k) << 8 * k;
      later[static_cast<std::size_t>(w)] = word;
    }
    // Bits before i are left over from earlier rows.
    later[static_cast<std::size_t>(first)] &= ~std::uint64_t{0} << (i % kWordBits);
    for_each_bit(later.data() + first, words_ - first, [&](int offset) {
      const int j = first * kWordBits + offset;
      if (angles && !angle_test(index, static_cast<std::size_t>(j))) return;
      join(i, j);
    });
  }
}

void ConsistencyGraph::join(int i, int j) {
  for (const auto& [a, b] : {std::pair{i, j}, std::pair{j, i}}) {
    bits_[static_cast<std::size_t>(std::ptrdiff_t{a} * words_ + b / kWordBits)] |=
        std::uint64_t{1} << (b % kWordBits);
    ++degrees_[static_cast<std::size_t>(a)];
  }
}

double ConsistencyGraph::density() const {
  if (size_ < 2) return 0;
  double sum = 0;
  for (const int degree : degrees_) sum += degree;
  return sum / (static_cast<double>(size_) * (size_ - 1));
}

std::vector<int> grow_clique(const ConsistencyGraph& graph, int seed, int max_size) {
  const int words = graph.words();
  std::vector<std::uint64_t> candidates(graph.row(seed), graph.row(seed) + words);
  std::vector<int> clique{seed};
  while (static_cast<int>(clique.size()) < max_size) {
    int best = -1, most = -1;
    for_each_bit(candidates.data(), words, [&](int vertex) {
      const int common = common_bits(graph.row(vertex), candidates.data(), words);
      if (common > most) {
        most = common;
        best = vertex;
      }
    });
    if (best < 0) break;
    clique.push_back(best);
    const std::uint64_t* row = graph.row(best);
    for (int w = 0; w < words; ++w) candidates[static_cast<std::size_t>(w)] &= row[w];
  }
  return clique;
}

}  // namespace palpate::registration
