// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "registration/bitset_rows.hpp"
#include "registration/pair_columns.hpp"

namespace palpate::registration {

/// The tests by which the consistency graph joins correspondences, a row at a time.
class PairGates {
 public:
  /// @param columns  in units of the noise bound, to outlive this; may change between rows
  /// @param length_tolerance  in noise bounds
  /// @param normal_noise_deg  per tangent axis; 0: normals are not used, and need not be there
  PairGates(const PairColumns& columns, double length_tolerance, double normal_noise_deg);

  int size() const { return columns_.size(); }
  int words() const { return (size() + kWordBits - 1) / kWordBits; }

  /// Which pairs are joined with i, which is not itself.
  /// @param bits  words() words
  void row(int i, std::uint64_t* bits);

 private:
  void narrow_by_lines(int i, std::uint64_t* bits) const;

  const PairColumns& columns_;
  float length_tolerance_, normal_noise_;
  std::vector<std::uint8_t> joined_;
};

}  // namespace palpate::registration
