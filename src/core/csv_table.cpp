// SPDX-License-Identifier: Apache-2.0
#include "core/csv_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "palpate/core/csv.hpp"
#include "palpate/core/error.hpp"

namespace palpate {
CsvTable::CsvTable(std::string_view text, std::string source)
    : text_(text), source_(std::move(source)) {
  if (!take_line()) throw BadInput(fmt::format("{} is empty: expected a CSV header", source_));
  names_ = cells_;
}

bool CsvTable::take_line() {
  while (!text_.empty()) {
    const auto end = std::min(text_.find('\n'), text_.size());
    const std::string_view line = trimmed(text_.substr(0, end));
    text_.remove_prefix(std::min(end + 1, text_.size()));
    ++line_;
    if (line.empty()) continue;
    cells_ = csv_cells(line);
    return true;
  }
  return false;
}

std::optional<std::size_t> CsvTable::find(std::string_view name) const {
  const auto found = std::find(names_.begin(), names_.end(), name);
  if (found == names_.end()) return std::nullopt;
  return static_cast<std::size_t>(found - names_.begin());
}

std::size_t CsvTable::require(std::string_view name) const {
  if (const auto column = find(name)) return *column;
  throw BadInput(fmt::format("{}:1: no column {} in the header", source_, name));
}

bool CsvTable::next() {
  if (!take_line()) return false;
  if (cells_.size() != names_.size()) {
    throw BadInput(fmt::format("{}:{}: {} cells for {} columns", source_, line_, cells_.size(),
                               names_.size()));
  }
  return true;
}

std::string CsvTable::where() const { return fmt::format("{}:{}", source_, line_); }

double CsvTable::number(std::size_t column) const {
  const std::string_view text = cells_[column];
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) {
    throw BadInput(fmt::format("{}:{}: '{}' in column {} is not a number", source_, line_, text,
                               names_[column]));
  }
  return value;
}

}  // namespace palpate
