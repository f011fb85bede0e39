// SPDX-License-Identifier: Apache-2.0
#include "palpate/tactile/biotac/log.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <limits>

#include "core/csv_table.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"

namespace palpate::tactile {
namespace {

constexpr std::array<std::string_view, kBiotacFlags> kNames = {
    "no_contact", "missing",      "out_of_range", "saturated", "stuck",      "repeated",
    "late",       "out_of_order", "drifted",      "no_rest",   "unexplained"};

constexpr unsigned kHarmless = static_cast<unsigned>(BiotacFlag::late) |
                               static_cast<unsigned>(BiotacFlag::out_of_order) |
                               static_cast<unsigned>(BiotacFlag::drifted);

struct Columns {
  explicit Columns(const palpate::CsvTable& table) : time(table.require("t_s")) {
    channels[0] = table.require("pdc");
    for (std::size_t e = 1; e < channels.size(); ++e) {
      channels[e] = table.require(fmt::format("e{}", e));
    }
    normals = table.find_xyz("n");
  }

  std::size_t time;
  std::array<std::size_t, kBiotacChannels> channels{};
  std::optional<palpate::CsvTable::Columns> normals;
};

double number_or_nan(const palpate::CsvTable& table, std::size_t column) {
  if (table.cell(column).empty()) return std::numeric_limits<double>::quiet_NaN();
  return table.number(column);
}

std::optional<Eigen::Vector3d> normal_of(const palpate::CsvTable& table, const Columns& columns,
                                         std::size_t row, const std::string& source) {
  if (!columns.normals) return std::nullopt;
  const auto& [x, y, z] = *columns.normals;
  const Eigen::Vector3d n(number_or_nan(table, x), number_or_nan(table, y),
                          number_or_nan(table, z));
  if (!n.allFinite()) return std::nullopt;
  if (n.norm() < 1e-6) {
    throw BadInput(fmt::format("{}: the normal of row {} has no direction", source, row));
  }
  return n.normalized();
}

}  // namespace

std::string biotac_flag_names(unsigned flags) {
  std::string names;
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    if ((flags & (1u << i)) == 0) continue;
    if (!names.empty()) names += '+';
    names += kNames[i];
  }
  return names;
}

bool biotac_usable(unsigned flags) { return (flags & ~kHarmless) == 0; }

BiotacLog parse_biotac_log(std::string_view text, const std::string& source) {
  palpate::CsvTable table(text, source);
  const Columns columns(table);
  BiotacLog log;
  log.name = std::filesystem::path(source).stem().string();
  while (table.next()) {
    log.time.push_back(table.number(columns.time));
    if (!std::isfinite(log.time.back())) {
      throw BadInput(fmt::format("{}: the time of row {} is not finite", source, log.time.size()));
    }
    BiotacChannels channels;
    for (std::size_t c = 0; c < columns.channels.size(); ++c) {
      channels[static_cast<Eigen::Index>(c)] = number_or_nan(table, columns.channels[c]);
    }
    log.channels.push_back(channels);
    log.normals.push_back(normal_of(table, columns, log.time.size(), source));
  }
  if (log.time.empty()) throw BadInput(fmt::format("{}: there are no rows", source));
  return log;
}

BiotacLog read_biotac_log(const std::filesystem::path& path) {
  return parse_biotac_log(read_file(path), path.string());
}

}  // namespace palpate::tactile
