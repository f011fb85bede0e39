// SPDX-License-Identifier: Apache-2.0
#include "palpate/registration/correspondences_io.hpp"

#include <fmt/format.h>

#include "core/csv_table.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/core/plausible.hpp"

namespace palpate::registration {
namespace {

double coordinate(const CsvTable& table, std::size_t column) {
  return plausible(table.finite(column), -kMaxCoordinate, kMaxCoordinate,
                   table.where() + ": a value");
}

Eigen::Vector3d point(const CsvTable& table, const CsvTable::Columns& columns) {
  return {coordinate(table, columns[0]), coordinate(table, columns[1]),
          coordinate(table, columns[2])};
}

Eigen::Vector3d normal(const CsvTable& table, const CsvTable::Columns& columns) {
  const Eigen::Vector3d n = point(table, columns);
  if (n.norm() > 1e-6) return n.normalized();
  throw BadInput(fmt::format("{}: a normal of length {}", table.where(), n.norm()));
}

double weight_of(const CsvTable& table, std::size_t column) {
  const double weight = coordinate(table, column);
  if (weight >= 0) return weight;
  throw BadInput(fmt::format("{}: weight {} is negative", table.where(), weight));
}

}  // namespace

Correspondences parse_correspondences(std::string_view text, std::string_view source) {
  CsvTable table(text, std::string(source));
  const auto s = table.require_xyz("s"), t = table.require_xyz("t");
  const auto sn = table.find_xyz("sn"), tn = table.find_xyz("tn");
  const auto weight = table.find("weight");
  Correspondences result;
  while (table.next()) {
    result.source.push_back(point(table, s));
    result.target.push_back(point(table, t));
    if (sn) result.source_normals.push_back(normal(table, *sn));
    if (tn) result.target_normals.push_back(normal(table, *tn));
    if (weight) result.weights.push_back(weight_of(table, *weight));
  }
  return result;
}

Correspondences read_correspondences(const std::filesystem::path& path) {
  return parse_correspondences(read_file(path), path.string());
}

}  // namespace palpate::registration
