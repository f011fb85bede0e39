// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "registration/pair_gates.hpp"

namespace palpate::registration {

/// The neighbourhood of one correspondence in the consistency graph, found without the rest of it:
/// those that are consistent with it, and which of these are with one another.
class EgoGraph {
 public:
  /// @param columns  in units of the noise bound, to outlive this
  EgoGraph(const PairColumns& columns, double length_tolerance, double normal_noise_deg)
      : all_(columns, length_tolerance, normal_noise_deg),
        near_(local_, length_tolerance, normal_noise_deg),
        columns_(columns) {}
  EgoGraph(const EgoGraph&) = delete;
  EgoGraph& operator=(const EgoGraph&) = delete;

  /// Moves to another centre.
  void look_around(int center);

  /// Consistent with the centre.
  const std::vector<int>& neighbours() const { return neighbours_; }
  /// The pairs themselves.
  const PairColumns& nearby() const { return local_; }
  /// Grown from the centre by the neighbour that keeps most others, the centre first.
  std::vector<int> clique(int max_size);

 private:
  PairColumns local_;  // of the neighbours
  PairGates all_, near_;
  const PairColumns& columns_;
  int center_ = 0, words_ = 0;
  std::vector<int> neighbours_;
  std::vector<std::uint64_t> row_, rows_, candidates_;  // rows_: among the neighbours
};

}  // namespace palpate::registration
