// SPDX-License-Identifier: Apache-2.0
#include "registration/clique_bound.hpp"

#include <algorithm>
#include <utility>

#include "registration/clock.hpp"

namespace palpate::registration {
namespace {

using Bits = CliqueBound::Bits;

void drop(Bits& bits, int vertex) {
  bits[static_cast<std::size_t>(vertex / kWordBits)] &= ~(std::uint64_t{1} << (vertex % kWordBits));
}

int first_of(const Bits& bits) {
  for (std::size_t w = 0; w < bits.size(); ++w) {
    if (bits[w] != 0) return static_cast<int>(w) * kWordBits + std::countr_zero(bits[w]);
  }
  return -1;
}

int count(const Bits& bits) {
  int total = 0;
  for (const std::uint64_t word : bits) total += std::popcount(word);
  return total;
}

Bits common(const Bits& bits, const std::uint64_t* row) {
  Bits result = bits;
  for (std::size_t w = 0; w < bits.size(); ++w) result[w] &= row[w];
  return result;
}

}  // namespace

/// One vertex after the other of those with fewest neighbours among the ones left, each with these
/// neighbours.
std::vector<CliqueBound::Root> CliqueBound::roots_by_degeneracy() {
  const int size = graph_.size();
  Bits left(static_cast<std::size_t>(graph_.words()), 0);
  std::vector<int> degrees(static_cast<std::size_t>(size), 0);
  for (int v = 0; v < size; ++v) {
    left[static_cast<std::size_t>(v / kWordBits)] |= std::uint64_t{1} << (v % kWordBits);
    for (int w = 0; w < graph_.words(); ++w) {
      degrees[static_cast<std::size_t>(v)] += std::popcount(graph_.row(v)[w]);
    }
  }
  std::vector<Root> roots;
  for (int k = 0; k < size; ++k) {
    if (is_late()) return {};
    int next = -1;
    for_each_bit(left.data(), graph_.words(), [&](int v) {
      const auto degree = [&](int i) { return degrees[static_cast<std::size_t>(i)]; };
      if (next < 0 || degree(v) < degree(next)) next = v;
    });
    drop(left, next);
    Bits later = common(left, graph_.row(next));
    for_each_bit(later.data(), graph_.words(),
                 [&](int v) { --degrees[static_cast<std::size_t>(v)]; });
    const int bound = 1 + count(later);
    if (bound > largest_) roots.push_back({next, bound, std::move(later)});
  }
  return roots;
}

bool CliqueBound::is_late() {
  out_of_work_ = out_of_work_ || now() > deadline_;
  return out_of_work_;
}

/// Whether one more subproblem may be looked at.
bool CliqueBound::spend() {
  out_of_work_ = out_of_work_ || nodes_ >= max_nodes_ || is_late();
  if (!out_of_work_) ++nodes_;
  return !out_of_work_;
}

CliqueBound::Colouring CliqueBound::colour(Bits candidates) {
  Colouring result;
  for (int colours = 1; first_of(candidates) >= 0; ++colours) {
    Bits same = candidates;
    for (int v = first_of(same); v >= 0; v = first_of(same)) {
      drop(same, v);
      drop(candidates, v);
      for (std::size_t w = 0; w < same.size(); ++w) same[w] &= ~graph_.row(v)[w];
      result.vertices.push_back(v);
      result.colours.push_back(colours);
    }
  }
  return result;
}

void CliqueBound::expand(Bits candidates, int size) {
  if (!spend()) return;
  const auto [vertices, colours] = colour(candidates);
  for (std::size_t i = vertices.size(); i-- > 0 && !out_of_work_;) {
    if (size + colours[i] <= largest_) return;
    Bits next = common(candidates, graph_.row(vertices[i]));
    if (first_of(next) < 0) {
      largest_ = std::max(largest_, size + 1);
    } else {
      expand(std::move(next), size + 1);
    }
    drop(candidates, vertices[i]);
  }
}

int CliqueBound::run() {
  std::vector<Root> roots = roots_by_degeneracy();
  if (out_of_work_) return graph_.size();
  for (Root& root : roots) {
    if (!spend()) break;
    const Colouring colouring = colour(root.later);
    root.bound = 1 + (colouring.colours.empty() ? 0 : colouring.colours.back());
  }
  std::ranges::stable_sort(roots, [](const Root& a, const Root& b) { return a.bound > b.bound; });
  for (const Root& root : roots) {
    if (root.bound <= largest_) break;
    expand(root.later, 1);
    if (out_of_work_) return root.bound;
  }
  return largest_;
}

}  // namespace palpate::registration
