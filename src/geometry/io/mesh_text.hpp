// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "palpate/core/csv.hpp"

namespace palpate::geometry {

/// Takes the first word (between blanks) off the front of `rest`; empty at the end.
std::string_view take_word(std::string_view& rest);

/// The whole word as a number, "nan" and "inf" included.
std::optional<double> parse_number(std::string_view word);
std::optional<long long> parse_integer(std::string_view word);

/// Reads a text file word by word or line by line and knows where it is.
class MeshText {
 public:
  /// A byte order mark is passed over.
  MeshText(std::string_view text, std::string_view file)
      : rest_(without_byte_order_mark(text)), file_(file) {}

  /// Next line without its end, or nothing at the end of the text. What is left of the line that
  /// words were taken from counts as read.
  std::optional<std::string_view> next_line();

  /// Next word, over as many lines as it takes. @throws BadInput at the end of the text
  std::string_view next_word();
  double next_number();

  /// What follows the current line.
  std::string_view rest() const { return rest_; }

  /// Number of characters not read yet.
  std::size_t left() const { return line_.size() + rest_.size(); }

  std::string_view file() const { return file_; }

  /// @throws BadInput "FILE: line N: WHAT"
  [[noreturn]] void fail(std::string_view what) const;

  /// @throws BadInput, with the word's unprintable characters replaced
  [[noreturn]] void fail_at(std::string_view what, std::string_view word) const;

 private:
  std::string_view rest_, line_;
  std::string file_;
  std::size_t line_number_ = 0;
};

}  // namespace palpate::geometry
