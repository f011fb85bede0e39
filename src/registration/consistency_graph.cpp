// SPDX-License-Identifier: Apache-2.0
#include "palpate/registration/consistency_graph.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <numbers>
#include <utility>

#include "palpate/core/error.hpp"

namespace palpate::registration {
namespace {

constexpr int kWordBits = 64;

// A second version for processors with wider registers, chosen when the program starts; the
// results are the same. Sanitizers start too late for that.
#if defined(__x86_64__) && defined(__linux__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_THREAD__) && !defined(__SANITIZE_ADDRESS__)
#define PALPATE_WIDE __attribute__((target_clones("avx2", "default")))
#else
#define PALPATE_WIDE
#endif

/// Coordinates one axis after the other, which compilers vectorise, in units of the noise bound.
struct Coordinates {
  std::vector<float> x, y, z;

  Coordinates(const std::vector<Eigen::Vector3d>& points, const Eigen::Vector3d& origin,
              double unit) {
    for (auto* axis : {&x, &y, &z}) axis->reserve(points.size());
    for (const auto& p : points) {
      const Eigen::Vector3f q = ((p - origin) / unit).cast<float>();
      x.push_back(q[0]);
      y.push_back(q[1]);
      z.push_back(q[2]);
    }
  }
  Eigen::Vector3f at(std::size_t i) const { return {x[i], y[i], z[i]}; }
};

/// joined[j], from j = first on, = whether |s_i s_j| and |t_i t_j| differ by at most g and the
/// first is above g. Without square roots: (A - B)^2 <= g^2 iff A^2 + B^2 <= g^2 or (A^2 - B^2)^2
/// <= 2 g^2 (A^2 + B^2) - g^4.
PALPATE_WIDE void compare_lengths(const Coordinates& s, const Coordinates& t, std::size_t i,
                                  std::size_t first, float g, std::uint8_t* __restrict joined) {
  const float g2 = g * g, g4 = g2 * g2;
  const float sx = s.x[i], sy = s.y[i], sz = s.z[i], tx = t.x[i], ty = t.y[i], tz = t.z[i];
  const float *ax = s.x.data(), *ay = s.y.data(), *az = s.z.data();
  const float *bx = t.x.data(), *by = t.y.data(), *bz = t.z.data();
  for (std::size_t j = first; j < s.x.size(); ++j) {
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

/// Narrows joined[j], from j = first on, to normals whose angle is the same in both frames.
PALPATE_WIDE void compare_normals(const Coordinates& n, const Coordinates& m, std::size_t i,
                                  std::size_t first, float cosine,
                                  std::uint8_t* __restrict joined) {
  const float nx = n.x[i], ny = n.y[i], nz = n.z[i], mx = m.x[i], my = m.y[i], mz = m.z[i];
  const float *ax = n.x.data(), *ay = n.y.data(), *az = n.z.data();
  const float *bx = m.x.data(), *by = m.y.data(), *bz = m.z.data();
  for (std::size_t j = first; j < n.x.size(); ++j) {
    const float a = nx * ax[j] + ny * ay[j] + nz * az[j];
    const float b = mx * bx[j] + my * by[j] + mz * bz[j];
    const float r = cosine - a * b, sines = (1 - a * a) * (1 - b * b);
    joined[j] &= static_cast<std::uint8_t>((r <= 0) | (sines >= r * r));
  }
}

/// Normals and points of both frames with the tolerances of their angles.
class AngleTest {
 public:
  AngleTest(const Correspondences& c, const Coordinates& s, const Coordinates& t, double noise_deg)
      : noise_(static_cast<float>(noise_deg * std::numbers::pi / 180)),
        n_(c.source_normals, Eigen::Vector3d::Zero(), 1),
        m_(c.target_normals, Eigen::Vector3d::Zero(), 1) {
    for (std::size_t i = 0; i < c.size(); ++i) {
      pairs_.push_back({s.at(i), t.at(i), n_.at(i), m_.at(i)});
    }
  }

  /// Narrows joined[j], from j = first on, by the angle between the two normals.
  void narrow(std::size_t i, std::size_t first, std::uint8_t* joined) const {
    // 3.6 standard deviations; an angle of two noisy normals varies sqrt 2 times as much.
    const float tolerance = 3.6F * 1.414F * noise_;
    if (tolerance >= std::numbers::pi_v<float>) return;
    compare_normals(n_, m_, i, first, std::cos(tolerance), joined);
  }

  /// Whether the angles between the normals and the line that joins the points agree.
  bool operator()(std::size_t i, std::size_t j) const {
    const Pair &a = pairs_[i], &b = pairs_[j];
    const Eigen::Vector3f d = b.s - a.s, e = b.t - a.t;
    const float d2 = d.squaredNorm(), e2 = e.squaredNorm(), length = std::sqrt(d2);
    // The line's own direction errs by 4.2 standard deviations of a position, 1/4 bound each.
    const float limit = low_cosine(3.6F * noise_ + 1.05F / length) * length * std::sqrt(e2);
    return angles_agree(a.n.dot(d), a.m.dot(e), d2, e2, limit) &&
           angles_agree(b.n.dot(d), b.m.dot(e), d2, e2, limit);
  }

 private:
  struct Pair {
    Eigen::Vector3f s, t, n, m;
  };

  float noise_;
  Coordinates n_, m_;
  std::vector<Pair> pairs_;
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
  const auto tolerance = static_cast<float>(options.length_tolerance);
  const AngleTest angle_test(angles ? correspondences : Correspondences{}, s, t,
                             options.normal_noise_deg);
  std::vector<std::uint8_t> joined(static_cast<std::size_t>(words_) * kWordBits);
  std::vector<std::uint64_t> words(static_cast<std::size_t>(words_));
  for (int i = 0; i < size_; ++i) {
    const auto index = static_cast<std::size_t>(i);
    // Angles cost more, so that they are compared once for both of a pair.
    const std::size_t first = angles ? index + 1 : 0;
    compare_lengths(s, t, index, first, tolerance, joined.data());
    joined[index] = 0;
    if (angles) angle_test.narrow(index, first, joined.data());
    const int first_word = angles ? i / kWordBits : 0;
    for (int w = first_word; w < words_; ++w) {
      std::uint64_t word = 0;
      for (int k = 0; k < 8; ++k) word |= pack(joined.data() + w * kWordBits + 8 * k) << 8 * k;
      words[static_cast<std::size_t>(w)] = word;
    }
    if (!angles) {
      std::ranges::copy(words, bits_.begin() + std::ptrdiff_t{i} * words_);
      degrees_[index] = common_bits(words.data(), words.data(), words_);
      continue;
    }
    // Bits before i are left over from earlier rows.
    words[static_cast<std::size_t>(first_word)] &= ~std::uint64_t{0} << (i % kWordBits);
    for_each_bit(words.data() + first_word, words_ - first_word, [&](int offset) {
      const int j = first_word * kWordBits + offset;
      if (angle_test(index, static_cast<std::size_t>(j))) join(i, j);
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

double ConsistencyGraph::triangles() const {
  double sum = 0;
  for (int i = 0; i < size_; ++i) {
    for_each_bit(row(i), words_, [&](int j) {
      if (j > i) sum += common_bits(row(i), row(j), words_);
    });
  }
  return sum / 3;
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
