// SPDX-License-Identifier: Apache-2.0
#include "palpate/geometry/cloud/feature_matching.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#ifdef __SSE2__
#include <emmintrin.h>
#endif

#include "palpate/core/error.hpp"
#include "palpate/core/parallel.hpp"

namespace palpate::geometry {
namespace {

constexpr int kLanes = 16;                // targets that are compared at a time
constexpr std::size_t kChunkBlocks = 32;  // of so many targets, that one thread looks at
constexpr std::int32_t kFar = std::numeric_limits<std::int32_t>::max();

using Four = std::int32_t __attribute__((vector_size(16)));  // of gcc and clang, on any machine
using Lanes = std::array<Four, kLanes / 4>;
using RowPair = std::array<std::int16_t, 2>;  // of one column

/// Features as integers, two rows next to one another: column by column, and in blocks of kLanes
/// columns, pair of rows by pair of rows.
struct IntegerFeatures {
  IntegerFeatures(const Features& features, float scale)
      : count(static_cast<std::size_t>(features.cols())),
        row_pairs(static_cast<std::size_t>(features.rows() + 1) / 2),
        blocks((count + kLanes - 1) / kLanes),
        columns(row_pairs * count),
        blocked(row_pairs * kLanes * blocks),
        squared_norms(kLanes * blocks, kFar / 2) {
    for (std::size_t i = 0; i < count; ++i) {
      std::int32_t sum = 0;
      for (Eigen::Index row = 0; row < features.rows(); ++row) {
        const auto value = static_cast<std::int16_t>(
            std::lround(scale * features(row, static_cast<Eigen::Index>(i))));
        const auto pair = static_cast<std::size_t>(row / 2),
                   half = static_cast<std::size_t>(row % 2);
        columns[i * row_pairs + pair][half] = value;
        blocked[(i / kLanes * row_pairs + pair) * kLanes + i % kLanes][half] = value;
        sum += std::int32_t{value} * value;
      }
      squared_norms[i] = sum;
    }
  }

  std::size_t count, row_pairs, blocks;
  std::vector<RowPair> columns, blocked;
  std::vector<std::int32_t> squared_norms;  // of what fills the last block: far
};

Four four_of(std::int32_t value) { return Four{value, value, value, value}; }

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

/// Products of a column with those of a block.
Lanes products(const RowPair* column, const RowPair* block, std::size_t row_pairs) {
  Lanes sums = {};
  for (std::size_t p = 0; p < row_pairs; ++p) {
    for (std::size_t k = 0; k < sums.size(); ++k) {
      sums[k] += pair_products(column[p], block + p * kLanes + 4 * k);
    }
  }
  return sums;
}

/// For each column the nearest one of another set, the first of equals, as far as was looked.
struct Nearest {
  explicit Nearest(std::size_t columns) : distances(columns, kFar), indices(columns, -1) {}

  void offer(std::size_t i, std::int32_t distance, int index) {
    if (distance >= distances[i]) return;
    distances[i] = distance;
    indices[i] = index;
  }

  std::vector<std::int32_t> distances;  // squared
  std::vector<int> indices;
};

/// All sources against the targets of one block.
void find_nearest(const IntegerFeatures& source, const IntegerFeatures& target, std::size_t block,
                  Nearest& of_sources, Nearest& of_targets) {
  const std::size_t first = block * kLanes, rows = source.row_pairs;
  Lanes norms, least;
  for (std::size_t k = 0; k < kLanes; ++k) {
    norms[k / 4][static_cast<int>(k % 4)] = target.squared_norms[first + k];
  }
  least.fill(four_of(kFar));
  for (std::size_t i = 0; i < source.count; ++i) {
    Lanes distances = products(&source.columns[i * rows], &target.blocked[first * rows], rows);
    const Four own = four_of(source.squared_norms[i]), best = four_of(of_sources.distances[i]);
    Four nearer = {};
    for (std::size_t k = 0; k < norms.size(); ++k) {
      distances[k] = own + norms[k] - 2 * distances[k];
      nearer |= (distances[k] < best) | (distances[k] < least[k]);
    }
    if ((nearer[0] | nearer[1] | nearer[2] | nearer[3]) == 0) continue;  // nearly always
    for (std::size_t k = 0; k < kLanes; ++k) {
      const std::int32_t distance = distances[k / 4][static_cast<int>(k % 4)];
      of_sources.offer(i, distance, static_cast<int>(first + k));
      of_targets.offer(first + k, distance, static_cast<int>(i));
      least[k / 4][static_cast<int>(k % 4)] = of_targets.distances[first + k];
    }
  }
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
  const float length = std::max(longest_column(source), longest_column(target));
  const float scale = length > 0 ? 16384 / length : 1;
  const IntegerFeatures from(source, scale), to(target, scale);
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
