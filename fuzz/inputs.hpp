// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "grammar.hpp"
#include "palpate/core/random.hpp"
#include "targets.hpp"

namespace palpate::fuzz {

constexpr unsigned kMaxSeconds = 20;    // for one input
constexpr int kMaxMegabytes = 4 << 10;  // of memory

struct Budget {
  double seconds = 1e9;
  std::size_t runs = static_cast<std::size_t>(-1);
  std::uint64_t seed = 1;
};

/// Inputs for a target: sentences of its grammar, its corpus, and mutations of both.
class Inputs {
 public:
  Inputs(const Target& target, const std::filesystem::path& source,
         const std::filesystem::path& work);

  /// The corpus as it is comes first, then what is made of it.
  std::string next(RandomStream& random);

  /// Another one: a sentence of the grammar, or these bytes with changes.
  std::string changed(std::string bytes, RandomStream& random) const;

  const std::vector<std::string>& seeds() const { return seeds_; }

 private:
  bool keep_bytes_;
  std::vector<std::string> seeds_;
  std::optional<Grammar> grammar_;
  std::size_t count_ = 0;
};

/// Writes one input for a target and loads it. @return whether it was accepted
/// @throws what the loader throws beside a BadInput of one line
bool try_input(const Target& target, std::string_view input, const std::filesystem::path& folder,
               RandomStream& random);

/// Prints how many inputs a target was given and accepted.
/// @return whether that shows that what lies behind its first check was reached
bool report(const Target& target, std::size_t runs, std::size_t accepted);

}  // namespace palpate::fuzz
