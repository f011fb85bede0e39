// SPDX-License-Identifier: Apache-2.0
#include "core/csv_table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>

#include "palpate/core/csv.hpp"
#include "palpate/core/error.hpp"

namespace palpate {
namespace {

constexpr std::size_t kShown = 60;  // characters of a header or a cell in a message

bool equal_but_for_case(std::string_view a, std::string_view b) {
  return std::ranges::equal(
      a, b, [](unsigned char x, unsigned char y) { return std::tolower(x) == std::tolower(y); });
}

}  // namespace

CsvTable::CsvTable(std::string_view text, std::string source)
    : text_(without_byte_order_mark(text)), source_(std::move(source)) {
  if (!take_line()) throw BadInput(fmt::format("{} is empty: expected a CSV header", source_));
  names_ = cells_;
}

/// Says how a header without columns x,y,z differs from one that has them.
void CsvTable::refuse_header(const std::string& wanted) const {
  const auto is_number = [](std::string_view cell) {
    double value = 0;
    const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
    return error == std::errc() && end == cell.data() + cell.size();
  };
  const std::string header(header_.substr(0, kShown));
  if (names_.size() == 1 || is_number(names_.front())) {
    throw BadInput(fmt::format("{}:1: expected a comma-separated header with {}; found '{}'",
                               source_, wanted, header));
  }
  const auto columns = csv_cells(wanted);
  const bool capitals = std::ranges::all_of(columns, [this](std::string_view column) {
    return std::ranges::any_of(names_, [&](auto name) { return equal_but_for_case(name, column); });
  });
  throw BadInput(fmt::format("{}:1: no columns {} in the header{}", source_,
                             fmt::join(columns, ", "),
                             capitals ? fmt::format(" {}; did you mean {}?", header, wanted) : ""));
}

bool CsvTable::take_line() {
  while (!text_.empty()) {
    const auto end = std::min(text_.find('\n'), text_.size());
    const std::string_view line = trimmed(text_.substr(0, end));
    text_.remove_prefix(std::min(end + 1, text_.size()));
    ++line_;
    if (line.empty()) continue;
    if (header_.empty()) header_ = line;
    cells_ = csv_cells(line);
    return true;
  }
  return false;
}

std::optional<std::size_t> CsvTable::find(std::string_view name) const {
  const auto found = std::find(names_.begin(), names_.end(), name);
  if (found == names_.end()) return std::nullopt;
  if (std::find(found + 1, names_.end(), name) != names_.end()) {
    throw BadInput(fmt::format("{}: the header names column {} twice", source_, name));
  }
  return static_cast<std::size_t>(found - names_.begin());
}

std::size_t CsvTable::require(std::string_view name) const {
  if (const auto column = find(name)) return *column;
  throw BadInput(fmt::format("{}:1: no column {} in the header", source_, name));
}

std::optional<CsvTable::Columns> CsvTable::find_xyz(std::string_view prefix) const {
  Columns columns;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto column = find(std::string(prefix) + "xyz"[axis]);
    if (!column) return std::nullopt;
    columns[axis] = *column;
  }
  return columns;
}

CsvTable::Columns CsvTable::require_xyz(std::string_view prefix) const {
  if (const auto columns = find_xyz(prefix)) return *columns;
  refuse_header(fmt::format("{0}x,{0}y,{0}z", prefix));
}

bool CsvTable::next() {
  if (!take_line()) return false;
  if (cells_.size() != names_.size()) {
    throw BadInput(
        fmt::format("{}: {} values for {} columns", where(), cells_.size(), names_.size()));
  }
  return true;
}

std::string CsvTable::where() const { return fmt::format("{}:{}", source_, line_); }

double CsvTable::number(std::size_t column) const {
  const std::string_view text = cells_[column];
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc() && end == text.data() + text.size()) return value;
  throw BadInput(fmt::format("{}: '{}' in column {} is not a number", where(),
                             text.substr(0, kShown), names_[column]));
}

double CsvTable::finite(std::size_t column) const {
  const std::string_view text = cells_[column];
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool complete = error == std::errc() && end == text.data() + text.size();
  if (complete && std::isfinite(value)) return value;
  throw BadInput(fmt::format("{}: '{}' in column {} is not a finite number", where(),
                             text.substr(0, kShown), names_[column]));
}

Eigen::Vector3d CsvTable::finite(const Columns& columns) const {
  return {finite(columns[0]), finite(columns[1]), finite(columns[2])};
}

}  // namespace palpate
