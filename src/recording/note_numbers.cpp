// SPDX-License-Identifier: Apache-2.0
#include "recording/note_numbers.hpp"

#include <sstream>

namespace palpate::recording {

std::vector<double> numbers_after(std::string_view word, const std::string& text) {
  if (!text.starts_with(word)) return {};
  std::istringstream in(text.substr(word.size()));
  std::vector<double> values;
  for (double value; in >> value;) values.push_back(value);
  return values;
}

std::vector<double> numbers_after(std::string_view word, const std::string& text,
                                  std::size_t count) {
  const auto values = numbers_after(word, text);
  return values.size() == count ? values : std::vector<double>{};
}

}  // namespace palpate::recording
