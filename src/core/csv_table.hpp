// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace palpate {

/// The rows of a CSV text with a header, one after the other. A byte order mark and blank lines are
/// passed over.
class CsvTable {
 public:
  using Columns = std::array<std::size_t, 3>;  ///< of x, y and z

  /// @param source  named in errors, as in "log.csv:3: ..."
  /// @throws BadInput for a text without a header
  CsvTable(std::string_view text, std::string source);

  [[nodiscard]] const std::vector<std::string_view>& names() const { return names_; }
  /// Column of that name. @throws BadInput if two have it
  [[nodiscard]] std::optional<std::size_t> find(std::string_view name) const;
  /// @throws BadInput if there is none
  [[nodiscard]] std::size_t require(std::string_view name) const;
  /// The columns PREFIXx, PREFIXy and PREFIXz.
  [[nodiscard]] std::optional<Columns> find_xyz(std::string_view prefix) const;
  /// @throws BadInput unless all three are there; it says so if the header looks like none, or like
  ///         one with other separators or in capitals
  [[nodiscard]] Columns require_xyz(std::string_view prefix) const;

  /// Goes to the next row that is not blank. @throws BadInput for one with too few or many cells
  bool next();
  /// Line of the row in the text, from 1 on.
  [[nodiscard]] std::size_t line() const { return line_; }
  /// "SOURCE:LINE" of the row.
  [[nodiscard]] std::string where() const;
  [[nodiscard]] std::string_view cell(std::size_t column) const { return cells_[column]; }
  /// @throws BadInput unless the cell is a number; "nan" is one
  [[nodiscard]] double number(std::size_t column) const;
  /// @throws BadInput also for nan and the infinities
  [[nodiscard]] double finite(std::size_t column) const;
  [[nodiscard]] Eigen::Vector3d finite(const Columns& columns) const;

 private:
  bool take_line();
  [[noreturn]] void refuse_header(const std::string& wanted) const;

  std::string_view text_;
  std::string source_;
  std::size_t line_ = 0;
  std::string_view header_;
  std::vector<std::string_view> names_, cells_;
};

}  // namespace palpate
