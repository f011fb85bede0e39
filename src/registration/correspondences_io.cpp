// SPDX-License-Identifier: Apache-2.0
#include "palpate/registration/correspondences_io.hpp"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <optional>

#include "palpate/core/csv.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/core/plausible.hpp"

namespace palpate::registration {
namespace {

using Triple = std::array<std::size_t, 3>;  // columns of x, y and z

/// A CSV file's header and where its rows are.
class Table {
 public:
  Table(std::string_view header, std::string_view source)
      : names_(csv_cells(header)), source_(source) {}

  std::optional<Triple> find(const std::string& prefix) const {
    Triple columns;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::string name = prefix + "xyz"[axis];
      std::size_t column = 0;
      while (column < names_.size() && names_[column] != name) ++column;
      if (column == names_.size()) return std::nullopt;
      columns[axis] = column;
    }
    return columns;
  }

  /// The column of that name.
  std::optional<std::size_t> column(std::string_view name) const {
    for (std::size_t k = 0; k < names_.size(); ++k) {
      if (names_[k] == name) return k;
    }
    return std::nullopt;
  }

  Triple require(const std::string& prefix) const {
    const auto columns = find(prefix);
    if (!columns) {
      throw BadInput(fmt::format("{}:1: no columns {}x, {}y, {}z in the header", source_, prefix,
                                 prefix, prefix));
    }
    return *columns;
  }

  std::vector<std::string_view> row(std::string_view line, std::size_t number) const {
    auto cells = csv_cells(line);
    if (cells.size() != names_.size()) {
      throw BadInput(fmt::format("{}:{}: {} values for {} columns", source_, number, cells.size(),
                                 names_.size()));
    }
    return cells;
  }

  /// Three of a row's cells; the others may hold anything.
  Eigen::Vector3d pick(const std::vector<std::string_view>& cells, const Triple& columns,
                       std::size_t number) const {
    return {value(cells, columns[0], number), value(cells, columns[1], number),
            value(cells, columns[2], number)};
  }

  double value(const std::vector<std::string_view>& cells, std::size_t column,
               std::size_t number) const {
    const std::string_view cell = cells[column];
    double parsed = 0;
    const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), parsed);
    const bool complete = error == std::errc() && end == cell.data() + cell.size();
    if (!complete || !std::isfinite(parsed)) {
      throw BadInput(fmt::format("{}:{}: '{}' in column {} is not a finite number", source_, number,
                                 cell, names_[column]));
    }
    return plausible(parsed, -kMaxCoordinate, kMaxCoordinate,
                     fmt::format("{}:{}: a value", source_, number));
  }

 private:
  std::vector<std::string_view> names_;
  std::string_view source_;
};

}  // namespace

Correspondences parse_correspondences(std::string_view text, std::string_view source) {
  std::optional<Table> table;
  std::optional<Triple> s, t, sn, tn;
  std::optional<std::size_t> weight;
  Correspondences result;
  const auto add_normal = [&](const Eigen::Vector3d& n, std::size_t number, auto& normals) {
    if (!(n.norm() > 1e-6)) {
      throw BadInput(fmt::format("{}:{}: a normal of length {}", source, number, n.norm()));
    }
    normals.push_back(n.normalized());
  };
  for (std::size_t number = 1; !text.empty(); ++number) {
    const auto end = std::min(text.find('\n'), text.size());
    const std::string_view line = trimmed(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.empty() && table) continue;
    if (!table) {
      table.emplace(line, source);
      s = table->require("s");
      t = table->require("t");
      sn = table->find("sn");
      tn = table->find("tn");
      weight = table->column("weight");
      continue;
    }
    const auto cells = table->row(line, number);
    result.source.push_back(table->pick(cells, *s, number));
    result.target.push_back(table->pick(cells, *t, number));
    if (sn) add_normal(table->pick(cells, *sn, number), number, result.source_normals);
    if (tn) add_normal(table->pick(cells, *tn, number), number, result.target_normals);
    if (!weight) continue;
    const double value = table->value(cells, *weight, number);
    if (value < 0)
      throw BadInput(fmt::format("{}:{}: weight {} is negative", source, number, value));
    result.weights.push_back(value);
  }
  if (!table) throw BadInput(fmt::format("{} is empty: expected a CSV header", source));
  return result;
}

Correspondences read_correspondences(const std::filesystem::path& path) {
  return parse_correspondences(read_file(path), path.string());
}

}  // namespace palpate::registration
