// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "palpate/registration/correspondences.hpp"

namespace palpate::registration {

struct ConsistencyOptions {
  double noise_bound = 0.004;      ///< m, largest error of an inlier's position
  double length_tolerance = 1.25;  ///< in noise bounds, on the difference of two lengths
  /// Noise of a normal per tangent axis, deg; with it, the three angles between the two normals
  /// and the line that joins the points must agree too. 0: normals are not used.
  double normal_noise_deg = 0;
};

/// Which correspondences can both be inliers of one rigid motion: it keeps lengths and angles.
///
/// Two pairs are joined if their distance is nearly the same in both frames and more than the
/// tolerance; shorter ones say nothing of the rotation.
class ConsistencyGraph {
 public:
  /// @throws BadInput as check(), and for a noise bound or tolerance that is not positive
  ConsistencyGraph(const Correspondences& correspondences, const ConsistencyOptions& options);

  int size() const { return size_; }
  int degree(int i) const { return degrees_[static_cast<std::size_t>(i)]; }
  bool joined(int i, int j) const { return row(i)[j / 64] >> (j % 64) & 1; }
  /// Share of all pairs of vertices that are joined; 0 for fewer than two vertices.
  double density() const;

  /// Neighbours of vertex i, 64 to a word.
  const std::uint64_t* row(int i) const { return bits_.data() + std::ptrdiff_t{i} * words_; }
  int words() const { return words_; }

 private:
  int size_ = 0, words_ = 0;
  std::vector<std::uint64_t> bits_;
  std::vector<int> degrees_;
};

/// A clique that holds `seed`, grown by the vertex that keeps most common neighbours, in the order
/// of joining; maximal unless it stops at max_size.
std::vector<int> grow_clique(const ConsistencyGraph& graph, int seed, int max_size);

}  // namespace palpate::registration
