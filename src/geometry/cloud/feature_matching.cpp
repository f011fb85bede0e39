// SPDX-License-Identifier: Apache-2.0
#include "palpate/geometry/cloud/feature_matching.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#ifdef __SSE2__
#include <immintrin.h>
#endif

#include "palpate/core/error.hpp"
#include "palpate/core/parallel.hpp"

#if defined(__x86_64__) && defined(__GNUC__)
#define PALPATE_AVX2  // where the processor has it
#endif

namespace palpate::geometry {
namespace {

constexpr std::size_t kLanes = 32;        // targets that are compared at a time
constexpr std::size_t kChunkBlocks = 16;  // of so many targets, that one thread looks at
constexpr std::int32_t kFar = std::numeric_limits<std::int32_t>::max();

using Four = std::int32_t __attribute__((vector_size(16)));  // of gcc and clang, on any machine
using RowPair = std::array<std::int16_t, 2>;                 // of one column

/// A pair of rows of the columns that are compared at a time.
struct alignas(64) RowOfPairs {
  std::array<RowPair, kLanes> pairs = {};
};

/// Features as integers, two rows next to one another: column by column, times -2, and in blocks of
/// kLanes columns, pair of rows by pair of rows.
struct IntegerFeatures {
  IntegerFeatures(const Features& features, float scale)
      : count(static_cast<std::size_t>(features.cols())),
        row_pairs(static_cast<std::size_t>(features.rows() + 1) / 2),
        blocks((count + kLanes - 1) / kLanes),
        columns(row_pairs * count),
        blocked(row_pairs * blocks),
        squared_norms(kLanes * blocks, kFar / 2) {
    for (std::size_t i = 0; i < count; ++i) {
      std::int32_t sum = 0;
      for (Eigen::Index row = 0; row < features.rows(); ++row) {
        const auto value = static_cast<std::int16_t>(
            std::lround(scale * features(row, static_cast<Eigen::Index>(i))));
        const auto pair = static_cast<std::size_t>(row / 2),
                   half = static_cast<std::size_t>(row % 2);
        columns[i * row_pairs + pair][half] = static_cast<std::int16_t>(-2 * value);
        blocked[i / kLanes * row_pairs + pair].pairs[i % kLanes][half] = value;
        sum += std::int32_t{value} * value;
      }
      squared_norms[i] = sum;
    }
  }

  std::size_t count, row_pairs, blocks;
  std::vector<RowPair> columns;
  std::vector<RowOfPairs> blocked;
  std::vector<std::int32_t> squared_norms;  // of what fills the last block: far
};

using Distances = std::array<std::int32_t, kLanes>;

/// Targets that are compared at a time, each with the nearest source so far.
struct Block {
  /// Of targets from `first` on.
  Block(const IntegerFeatures& target, std::size_t first)
      : rows(&target.blocked[first / kLanes * target.row_pairs]) {
    std::copy_n(&target.squared_norms[first], kLanes, squared_norms.begin());
    distances.fill(kFar);
    indices.fill(-1);
  }

  void offer(const Distances& from_source, int source) {
    for (std::size_t k = 0; k < kLanes; ++k) {
      const bool nearer = from_source[k] < distances[k];
      distances[k] = nearer ? from_source[k] : distances[k];
      indices[k] = nearer ? source : indices[k];
    }
  }

  const RowOfPairs* rows;
  alignas(64) Distances squared_norms, distances, indices;
};

/// For each of four columns the sum of its two products.
Four pair_products(const RowPair& pair, const RowPair* columns) {
#ifdef __SSE2__
  const __m128i value = _mm_set1_epi32(std::bit_cast<std::int32_t>(pair));
  const auto* four = reinterpret_cast<const __m128i*>(columns);
  return std::bit_cast<Four>(_mm_madd_epi16(value, _mm_loadu_si128(four)));
#else
  Four sums;
  for (int k = 0; k < 4; ++k) sums[k] = pair[0] * columns[k][0] + pair[1] * columns[k][1];
  return sums;
#endif
}

Four four_of(const Distances& values, std::size_t k) {
  Four four;
  std::memcpy(&four, &values[4 * k], sizeof four);
  return four;
}

/// Squared distances of source i from the targets of a block.
/// @param best  of that source so far
/// @return whether any is the nearest so far of that target or of that source
bool find_distances(const IntegerFeatures& source, std::size_t i, std::int32_t best,
                    const Block& block, Distances& distances) {
  const RowPair* column = &source.columns[i * source.row_pairs];
  std::array<Four, kLanes / 4> sums;
  for (std::size_t k = 0; k < sums.size(); ++k) {
    sums[k] = source.squared_norms[i] + four_of(block.squared_norms, k);
  }
  for (std::size_t p = 0; p < source.row_pairs; ++p) {
    for (std::size_t k = 0; k < sums.size(); ++k) {
      sums[k] += pair_products(column[p], &block.rows[p].pairs[4 * k]);
    }
  }
  Four nearer = {};
  for (std::size_t k = 0; k < sums.size(); ++k) {
    nearer |= (sums[k] < best) | (sums[k] < four_of(block.distances, k));
  }
  std::memcpy(distances.data(), sums.data(), sizeof distances);
  return (nearer[0] | nearer[1] | nearer[2] | nearer[3]) != 0;
}

#ifdef PALPATE_AVX2
[[gnu::target("avx2")]] __m256i eight_of(const void* values) {
  return _mm256_loadu_si256(static_cast<const __m256i*>(values));
}

/// find_distances() with registers twice as wide.
[[gnu::target("avx2")]] bool find_distances_wide(const IntegerFeatures& source, std::size_t i,
                                                 std::int32_t best, const Block& block,
                                                 Distances& distances) {
  constexpr int kEights = kLanes / 8;
  const RowPair* column = &source.columns[i * source.row_pairs];
  const __m256i own = _mm256_set1_epi32(source.squared_norms[i]), least = _mm256_set1_epi32(best);
  __m256i sums[kEights];
  for (int k = 0; k < kEights; ++k) {
    sums[k] = _mm256_add_epi32(own, eight_of(&block.squared_norms[8 * k]));
  }
  for (std::size_t p = 0; p < source.row_pairs; ++p) {
    const __m256i pair = _mm256_set1_epi32(std::bit_cast<std::int32_t>(column[p]));
    for (int k = 0; k < kEights; ++k) {
      const __m256i targets = eight_of(&block.rows[p].pairs[8 * k]);
      sums[k] = _mm256_add_epi32(sums[k], _mm256_madd_epi16(pair, targets));
    }
  }
  __m256i nearer = _mm256_setzero_si256();
  for (int k = 0; k < kEights; ++k) {
    const __m256i farther = _mm256_max_epi32(least, eight_of(&block.distances[8 * k]));
    nearer = _mm256_or_si256(nearer, _mm256_cmpgt_epi32(farther, sums[k]));
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(&distances[8 * k]), sums[k]);
  }
  return !_mm256_testz_si256(nearer, nearer);
}
#endif

bool (*fastest_find_distances())(const IntegerFeatures&, std::size_t, std::int32_t, const Block&,
                                 Distances&) {
#ifdef PALPATE_AVX2
  if (__builtin_cpu_supports("avx2")) return find_distances_wide;
#endif
  return find_distances;
}

/// For each column the nearest one of another set, the first of equals, as far as was looked.
struct Nearest {
  explicit Nearest(std::size_t columns) : distances(columns, kFar), indices(columns, -1) {}

  std::vector<std::int32_t> distances;  // squared
  std::vector<int> indices;
};

/// All sources against the targets of one block.
void find_nearest(const IntegerFeatures& source, const IntegerFeatures& target, std::size_t block,
                  Nearest& of_sources, Nearest& of_targets) {
  static const auto kFindDistances = fastest_find_distances();
  const std::size_t first = block * kLanes;
  Block targets(target, first);
  Distances distances;
  for (std::size_t i = 0; i < source.count; ++i) {
    std::int32_t& best = of_sources.distances[i];
    if (!kFindDistances(source, i, best, targets, distances)) continue;  // mostly
    targets.offer(distances, static_cast<int>(i));
    std::int32_t least = kFar;
    for (const std::int32_t distance : distances) least = std::min(least, distance);
    if (least >= best) continue;
    best = least;
    of_sources.indices[i] = static_cast<int>(
        first + static_cast<std::size_t>(std::ranges::find(distances, least) - distances.begin()));
  }
  std::ranges::copy(targets.distances, &of_targets.distances[first]);
  std::ranges::copy(targets.indices, &of_targets.indices[first]);
}

float longest_column(const Features& features) {
  if (!features.allFinite()) throw BadInput("features hold nan or inf");
  return features.cols() == 0 ? 0 : features.colwise().stableNorm().maxCoeff();
}

}  // namespace

std::vector<Match> mutual_matches(const Features& source, const Features& target, int threads) {
  if (source.cols() == 0 || target.cols() == 0) return {};
  if (source.rows() != target.rows()) {
    throw BadInput(
        fmt::format("features of {} and {} values do not match", source.rows(), target.rows()));
  }
  const Features* sides[] = {&source, &target};
  float lengths[2];
  parallel_for(2, threads, [&](std::size_t k) { lengths[k] = longest_column(*sides[k]); });
  const float length = std::max(lengths[0], lengths[1]);
  const float scale = length > 0 ? 16383 / length : 1;  // -2 times that is a short integer
  std::optional<IntegerFeatures> integers[2];
  parallel_for(2, threads, [&](std::size_t k) { integers[k].emplace(*sides[k], scale); });
  const IntegerFeatures &from = *integers[0], &to = *integers[1];
  const std::size_t chunks = (to.blocks + kChunkBlocks - 1) / kChunkBlocks;
  std::vector<Nearest> of_sources(chunks, Nearest(from.count));
  Nearest of_targets(to.blocks * kLanes);
  parallel_for(chunks, threads, [&](std::size_t chunk) {
    const std::size_t first = chunk * kChunkBlocks, end = std::min(to.blocks, first + kChunkBlocks);
    for (std::size_t block = first; block < end; ++block) {
      find_nearest(from, to, block, of_sources[chunk], of_targets);
    }
  });
  std::vector<Match> matches;
  for (std::size_t i = 0; i < from.count; ++i) {
    const auto& best = *std::ranges::min_element(
        of_sources, {}, [i](const Nearest& chunk) { return chunk.distances[i]; });
    const int j = best.indices[i];
    if (j >= 0 && of_targets.indices[static_cast<std::size_t>(j)] == static_cast<int>(i)) {
      matches.push_back({static_cast<int>(i), j});
    }
  }
  return matches;
}

}  // namespace palpate::geometry
