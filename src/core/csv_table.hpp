// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace palpate {

/// The rows of a CSV text with a header, one after the other.
class CsvTable {
 public:
  /// @param source  named in errors, as in "log.csv:3: ..."
  /// @throws BadInput for a text without a header
  CsvTable(std::string_view text, std::string source);

  /// Column of that name.
  [[nodiscard]] std::optional<std::size_t> find(std::string_view name) const;
  /// @throws BadInput if there is none
  [[nodiscard]] std::size_t require(std::string_view name) const;

  /// Goes to the next row that is not blank. @throws BadInput for one with too few or many cells
  bool next();
  /// "SOURCE:LINE" of the row.
  [[nodiscard]] std::string where() const;
  [[nodiscard]] std::string_view cell(std::size_t column) const { return cells_[column]; }
  /// @throws BadInput unless the cell is a number; "nan" is one
  [[nodiscard]] double number(std::size_t column) const;

 private:
  bool take_line();

  std::string_view text_;
  std::string source_;
  std::size_t line_ = 0;
  std::vector<std::string_view> names_, cells_;
};

}  // namespace palpate
