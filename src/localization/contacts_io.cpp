// SPDX-License-Identifier: Apache-2.0
#include "palpate/localization/contacts_io.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/csv_table.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/core/plausible.hpp"
#include "palpate/core/spelling.hpp"
#include "palpate/hand/description.hpp"
#include "palpate/hand/shadow.hpp"

namespace palpate::localization {
namespace {

constexpr double kLengthTolerance = 0.01;  // of a normal's length, for rounded components

// The last three are of the file that `palpate sense` writes for a finger, and are not read.
const std::vector<std::string> kContactColumns = {
    "x", "y",      "z",  "nx", "ny", "nz",        "point_sigma", "normal_sigma", "group",
    "t", "finger", "fx", "fy", "fz", "sigma_deg", "error_deg",   "flags"};
const std::vector<std::string> kPlaneColumns = {"nx", "ny", "nz", "height", "sigma"};

/// A column that is misspelt must not be passed over. One without a name is: tables of Python often
/// begin with their row numbers. @throws BadInput
void check_columns(const CsvTable& table, std::string_view source,
                   const std::vector<std::string>& known) {
  for (const std::string_view name : table.names()) {
    if (name.empty() || std::ranges::find(known, name) != known.end()) continue;
    throw BadInput(fmt::format("{}:1: unknown column '{}' (known: {}){}", source, name,
                               fmt::join(known, ", "), did_you_mean(name, known)));
  }
}

/// Where the header has what of a contact.
struct ContactColumns {
  explicit ContactColumns(const CsvTable& table)
      : point(table.require_xyz("")),
        normal(find_normal(table)),
        force(table.find_xyz("f")),
        time(table.find("t")),
        finger(table.find("finger")),
        group(table.find("group")),
        point_sigma(table.find("point_sigma")),
        normal_sigma(table.find("normal_sigma")) {}

  /// All three columns or none of them.
  static std::optional<CsvTable::Columns> find_normal(const CsvTable& table) {
    if (!table.find("nx") && !table.find("ny") && !table.find("nz")) return std::nullopt;
    return table.require_xyz("n");
  }

  CsvTable::Columns point;
  std::optional<CsvTable::Columns> normal, force;
  std::optional<std::size_t> time, finger, group, point_sigma, normal_sigma;
};

Eigen::Vector3d unit_normal_of(const CsvTable& row, const CsvTable::Columns& columns) {
  const Eigen::Vector3d n = row.finite(columns);
  if (!(std::abs(n.norm() - 1) <= kLengthTolerance)) {
    throw BadInput(fmt::format("{}: a normal of length {:.4g}, not 1", row.where(), n.norm()));
  }
  return n.normalized();
}

/// Outward unit normal; zero where the row leaves its three cells empty.
Eigen::Vector3d normal_of(const CsvTable& row, const CsvTable::Columns& columns) {
  const bool none = std::all_of(columns.begin(), columns.end(),
                                [&](std::size_t column) { return row.cell(column).empty(); });
  return none ? Eigen::Vector3d::Zero() : unit_normal_of(row, columns);
}

/// The cell's standard deviation; `otherwise` where there is no column or the cell is empty.
/// @param unit  of the column
/// @param most  that the model of contacts can represent
double sigma_of(const CsvTable& row, std::optional<std::size_t> column, double otherwise,
                std::string_view unit, double most) {
  if (!column || row.cell(*column).empty()) return otherwise;
  const double sigma = row.finite(*column);
  if (!(sigma > 0 && sigma <= most)) {
    throw BadInput(fmt::format("{}: {} is {} {}, but must be positive and at most {:.3g}",
                               row.where(), row.names()[*column], sigma, unit, most));
  }
  return sigma;
}

int group_of(const CsvTable& row, std::optional<std::size_t> column) {
  if (!column || row.cell(*column).empty()) return -1;
  const std::string_view cell = row.cell(*column);
  int group = -1;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), group);
  if (error != std::errc() || end != cell.data() + cell.size() || group < 0) {
    throw BadInput(fmt::format("{}: group is '{}', not an integer >= 0", row.where(), cell));
  }
  return group;
}

/// The index of a finger, by number or by the Shadow hand's name.
int finger_of(std::string_view cell) {
  const auto& names = hand::kShadowFingerNames;
  const auto name = std::find(names.begin(), names.end(), cell);
  if (name != names.end()) return static_cast<int>(name - names.begin());
  int index = -1;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), index);
  // Other names are a hand's own; the search does not need them.
  return error == std::errc() && end == cell.data() + cell.size() ? index : -1;
}

tactile::Contact contact_of(const CsvTable& row, const ContactColumns& columns,
                            const ContactNoise& noise) {
  tactile::Contact contact;
  contact.p = row.finite(columns.point);
  check_plausible(contact.p, kMaxLength,
                  row.where() + ": a coordinate in m (is the file in millimetres?)");
  if (columns.normal) contact.n = normal_of(row, *columns.normal);
  contact.time = columns.time ? row.finite(*columns.time) : 0;
  contact.finger = columns.finger ? finger_of(row.cell(*columns.finger)) : -1;
  contact.f = columns.force ? row.finite(*columns.force) : Eigen::Vector3d::Zero();
  check_plausible(contact.f, kMaxForce, row.where() + ": a force");
  contact.point_sigma = sigma_of(row, columns.point_sigma, noise.point, "m", kMaxPointSigma);
  contact.normal_sigma =
      sigma_of(row, columns.normal_sigma, noise.normal, "rad", std::numbers::pi / 2);
  contact.group = group_of(row, columns.group);
  return contact;
}

struct ContactRow {
  tactile::Contact contact;
  std::size_t line;
};

/// In the order of time.
std::vector<ContactRow> parse_rows(std::string_view text, std::string_view source,
                                   const ContactNoise& noise) {
  CsvTable table(text, std::string(source));
  const ContactColumns columns(table);
  check_columns(table, source, kContactColumns);
  std::vector<ContactRow> rows;
  while (table.next()) rows.push_back({contact_of(table, columns, noise), table.line()});
  std::stable_sort(rows.begin(), rows.end(),
                   [](const auto& a, const auto& b) { return a.contact.time < b.contact.time; });
  return rows;
}

}  // namespace

std::vector<tactile::Contact> parse_contacts(std::string_view text, std::string_view source,
                                             const ContactNoise& noise) {
  std::vector<tactile::Contact> contacts;
  for (auto& row : parse_rows(text, source, noise)) contacts.push_back(std::move(row.contact));
  return contacts;
}

std::vector<std::size_t> contact_lines(std::string_view text, std::string_view source) {
  std::vector<std::size_t> lines;
  for (const auto& row : parse_rows(text, source, {})) lines.push_back(row.line);
  return lines;
}

std::vector<tactile::Contact> read_contacts(const std::filesystem::path& path,
                                            const ContactNoise& noise) {
  return parse_contacts(read_file(path), path.string(), noise);
}

std::vector<PlaneContact> read_plane_contacts(const std::filesystem::path& path) {
  const std::string text = read_file(path);
  CsvTable row(text, path.string());
  const CsvTable::Columns normal = row.require_xyz("n");
  const std::size_t height = row.require("height");
  const auto sigma = row.find("sigma");
  check_columns(row, path.string(), kPlaneColumns);
  std::vector<PlaneContact> planes;
  while (row.next()) {
    PlaneContact plane{unit_normal_of(row, normal), row.finite(height)};
    plausible(plane.height, -kMaxLength, kMaxLength, row.where() + ": a height in m");
    plane.sigma = sigma_of(row, sigma, plane.sigma, "m", kMaxLength);
    planes.push_back(plane);
  }
  return planes;
}

}  // namespace palpate::localization
