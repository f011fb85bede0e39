// SPDX-License-Identifier: Apache-2.0
#include "option_suggestion.hpp"

#include <algorithm>
#include <numeric>

namespace palpate {
namespace {

/// Users also leave out the sections: "way" for "lift.way".
std::size_t distance(std::string_view key, std::string_view known) {
  const std::size_t whole = edit_distance(key, known);
  const std::size_t dot = known.rfind('.');
  if (dot == std::string_view::npos || key.find('.') != std::string_view::npos) return whole;
  return std::min(whole, edit_distance(key, known.substr(dot + 1)));
}

}  // namespace

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i + 1);
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row.back();
}

std::string nearest_key(std::string_view key, const std::vector<OptionField>& fields) {
  const auto nearest = std::min_element(fields.begin(), fields.end(), [&](auto& a, auto& b) {
    return distance(key, a.key) < distance(key, b.key);
  });
  return nearest == fields.end() ? "" : nearest->key;
}

}  // namespace palpate
