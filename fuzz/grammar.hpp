// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/core/random.hpp"

namespace palpate::fuzz {

/// A context-free grammar whose sentences are files of a format, wrong ones among them.
///
/// A line "rule = alternative || alternative" each; the first rule is the start. In an alternative
/// `<rule>` stands for a sentence of that rule, and \n, \t, \\, \xHH for those bytes. Built in are
/// <int> and <real> (plain and hostile numbers), <word>, and <bytes> (random, up to 64).
class Grammar {
 public:
  /// @throws BadInput for a line that is no rule, or a name without one
  explicit Grammar(const std::filesystem::path& path);

  /// A sentence; past some depth each rule takes its first alternative, which should end.
  std::string sentence(RandomStream& random) const;

 private:
  void expand(std::string_view text, int depth, RandomStream& random, std::string& out) const;
  bool expand_built_in(std::string_view name, RandomStream& random, std::string& out) const;

  std::map<std::string, std::vector<std::string>, std::less<>> rules_;
  std::string start_;
};

/// A number as it may stand in a text: small, or at and beyond the ends of the types.
std::string hostile_integer(RandomStream& random);
std::string hostile_real(RandomStream& random);

}  // namespace palpate::fuzz
