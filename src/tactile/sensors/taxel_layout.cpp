// SPDX-License-Identifier: Apache-2.0
#include "palpate/tactile/sensors/taxel_layout.hpp"

#include <fmt/format.h>

#include <optional>

#include "core/csv_table.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/core/plausible.hpp"

namespace palpate::tactile {
namespace {

constexpr double kMinNormal = 1e-6;

double cell_or(const CsvTable& row, std::optional<std::size_t> column, double otherwise) {
  return column && !row.cell(*column).empty() ? row.finite(*column) : otherwise;
}

}  // namespace

TaxelLayout parse_taxel_layout(std::string_view text, std::string_view source) {
  CsvTable table(text, std::string(source));
  const auto finger = table.find("finger");
  if (!finger) throw BadInput(fmt::format("{}: no column finger", source));
  const auto point = table.require_xyz(""), normal = table.require_xyz("n");
  const auto gain = table.find("gain"), zero = table.find("zero");
  TaxelLayout layout;
  while (table.next()) {
    TaxelCell cell{table.finite(point), table.finite(normal), cell_or(table, gain, 1),
                   cell_or(table, zero, 0)};
    check_plausible(cell.p, kMaxLength, table.where() + ": a coordinate in m");
    if (!(cell.n.norm() > kMinNormal)) {
      throw BadInput(fmt::format("{}: a normal of length {}", table.where(), cell.n.norm()));
    }
    cell.n.normalize();
    layout[std::string(table.cell(*finger))].push_back(cell);
  }
  if (layout.empty()) throw BadInput(fmt::format("{}: no taxels", source));
  return layout;
}

TaxelLayout read_taxel_layout(const std::filesystem::path& path) {
  return parse_taxel_layout(read_file(path), path.string());
}

std::vector<Contact> contacts_of_values(const std::vector<TaxelCell>& cells,
                                        std::span<const double> values,
                                        const TaxelOptions& options) {
  if (values.size() != cells.size()) {
    throw BadInput(fmt::format("{} values of {} taxels", values.size(), cells.size()));
  }
  std::vector<Taxel> taxels;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const TaxelCell& cell = cells[i];
    const double force = cell.gain * (values[i] - cell.zero);
    taxels.push_back({cell.p, cell.n, plausible(force, -kMaxForce, kMaxForce, "a taxel's force")});
  }
  return contacts_of_taxels(taxels, Eigen::Isometry3d::Identity(), options);
}

}  // namespace palpate::tactile
