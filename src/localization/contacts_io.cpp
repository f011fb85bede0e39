// SPDX-License-Identifier: Apache-2.0
#include "palpate/localization/contacts_io.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <string>

#include "core/csv_table.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/core/plausible.hpp"
#include "palpate/hand/description.hpp"

namespace palpate::localization {
namespace {

constexpr double kMinNormal = 1e-6;
/// Where the header has what of a contact.
struct ContactColumns {
  explicit ContactColumns(const CsvTable& table)
      : point(table.require_xyz("")),
        normal(table.require_xyz("n")),
        force(table.find_xyz("f")),
        time(table.find("t")),
        finger(table.find("finger")) {}

  CsvTable::Columns point, normal;
  std::optional<CsvTable::Columns> force;
  std::optional<std::size_t> time, finger;
};

int finger_of(std::string_view cell) {
  int index = -1;  // other names are a hand's own; the search does not need them
  std::from_chars(cell.data(), cell.data() + cell.size(), index);
  return index;
}

tactile::Contact contact_of(const CsvTable& row, const ContactColumns& columns,
                            const ContactNoise& noise) {
  tactile::Contact contact;
  contact.p = row.finite(columns.point);
  check_plausible(contact.p, kMaxLength,
                  row.where() + ": a coordinate in m (is the file in millimetres?)");
  const Eigen::Vector3d n = row.finite(columns.normal);
  if (!(n.norm() > kMinNormal)) {
    throw BadInput(fmt::format("{}: a normal of length {}", row.where(), n.norm()));
  }
  contact.n = n.normalized();
  contact.time = columns.time ? row.finite(*columns.time) : 0;
  contact.finger = columns.finger ? finger_of(row.cell(*columns.finger)) : -1;
  contact.f = columns.force ? row.finite(*columns.force) : Eigen::Vector3d::Zero();
  check_plausible(contact.f, kMaxForce, row.where() + ": a force");
  contact.point_sigma = noise.point;
  contact.normal_sigma = noise.normal;
  return contact;
}

}  // namespace

std::vector<tactile::Contact> parse_contacts(std::string_view text, std::string_view source,
                                             const ContactNoise& noise) {
  CsvTable table(text, std::string(source));
  const ContactColumns columns(table);
  std::vector<tactile::Contact> contacts;
  while (table.next()) contacts.push_back(contact_of(table, columns, noise));
  std::stable_sort(contacts.begin(), contacts.end(),
                   [](const auto& a, const auto& b) { return a.time < b.time; });
  return contacts;
}

std::vector<tactile::Contact> read_contacts(const std::filesystem::path& path,
                                            const ContactNoise& noise) {
  return parse_contacts(read_file(path), path.string(), noise);
}

}  // namespace palpate::localization
