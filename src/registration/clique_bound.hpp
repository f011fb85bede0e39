// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "registration/bitset_rows.hpp"

namespace palpate::registration {

/// An undirected graph as rows of bits.
class CliqueGraph {
 public:
  explicit CliqueGraph(int size)
      : size_(size),
        words_((size + kWordBits - 1) / kWordBits),
        bits_(static_cast<std::size_t>(size) * static_cast<std::size_t>(words_), 0) {}

  int size() const { return size_; }
  int words() const { return words_; }
  const std::uint64_t* row(int i) const { return bits_.data() + std::ptrdiff_t{i} * words_; }
  void join(int i, int j) {
    set(i, j);
    set(j, i);
  }

 private:
  void set(int i, int j) {
    bits_[static_cast<std::size_t>(std::ptrdiff_t{i} * words_ + j / kWordBits)] |=
        std::uint64_t{1} << (j % kWordBits);
  }

  int size_, words_;
  std::vector<std::uint64_t> bits_;
};

/// Upper bound on the size of the largest clique, at least `known`, by as much work as is allowed.
class CliqueBound {
 public:
  using Bits = std::vector<std::uint64_t>;

  /// @param known  cliques of at most this size do not matter
  /// @param deadline  as now()
  CliqueBound(const CliqueGraph& graph, int known, int max_nodes, double deadline)
      : graph_(graph), largest_(known), max_nodes_(max_nodes), deadline_(deadline) {}

  /// Every clique has a first vertex in the order of degeneracy, among whose later neighbours the
  /// rest of it is.
  int run();

  bool is_exhausted() const { return !out_of_work_; }
  int nodes() const { return nodes_; }

 private:
  /// The cliques that begin with a vertex.
  struct Root {
    int vertex = 0, bound = 0;
    Bits later;
  };
  /// Vertices in the order of a greedy colouring, each with the colours used so far.
  struct Colouring {
    std::vector<int> vertices, colours;
  };

  std::vector<Root> roots_by_degeneracy();
  Colouring colour(Bits candidates);
  void expand(Bits candidates, int size);
  bool spend();
  bool is_late();

  const CliqueGraph& graph_;
  int largest_, max_nodes_, nodes_ = 0;
  double deadline_;
  bool out_of_work_ = false;
};

}  // namespace palpate::registration
