// SPDX-License-Identifier: Apache-2.0
#include "geometry/io/mesh_text.hpp"

#include <fmt/format.h>

#include <charconv>

#include "geometry/mesh/mesh_builder.hpp"

namespace palpate::geometry {
namespace {

constexpr std::string_view kBlanks = " \t\r\n\v\f";

template <typename Number>
std::optional<Number> parse_all(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  Number value{};
  const char* end = word.data() + word.size();
  const auto [stop, error] = std::from_chars(word.data(), end, value);
  if (error != std::errc() || stop != end) return std::nullopt;
  return value;
}

std::string printable(std::string_view word) {
  constexpr std::size_t kMaxShown = 40;
  std::string shown(word.substr(0, kMaxShown));
  for (char& c : shown) {
    if (c < ' ' || c > '~') c = '?';
  }
  return shown;
}

}  // namespace

std::string_view take_word(std::string_view& rest) {
  rest.remove_prefix(std::min(rest.find_first_not_of(kBlanks), rest.size()));
  const std::string_view word = rest.substr(0, rest.find_first_of(kBlanks));
  rest.remove_prefix(word.size());
  return word;
}

std::optional<double> parse_number(std::string_view word) { return parse_all<double>(word); }

std::optional<long long> parse_integer(std::string_view word) { return parse_all<long long>(word); }

std::optional<std::string_view> MeshText::next_line() {
  if (rest_.empty()) return std::nullopt;
  const std::size_t end = rest_.find('\n');
  const std::string_view line = rest_.substr(0, end);
  rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
  ++line_number_;
  line_ = {};
  return line;
}

std::string_view MeshText::next_word() {
  while (true) {
    const std::string_view word = take_word(line_);
    if (!word.empty()) return word;
    const auto line = next_line();
    if (!line) fail("the file ends too early");
    line_ = *line;
  }
}

double MeshText::next_number() {
  const std::string_view word = next_word();
  const auto number = parse_number(word);
  if (!number) fail_at("expected a number, not", word);
  return *number;
}

void MeshText::fail(std::string_view what) const {
  bad_file(file_, fmt::format("line {}: {}", line_number_, what));
}

void MeshText::fail_at(std::string_view what, std::string_view word) const {
  fail(fmt::format("{} '{}'", what, printable(word)));
}

}  // namespace palpate::geometry
