// SPDX-License-Identifier: Apache-2.0
#include "palpate/localization/contacts_io.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <string>

#include "palpate/core/csv.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/core/plausible.hpp"
#include "palpate/hand/joints.hpp"

namespace palpate::localization {
namespace {

constexpr double kMinNormal = 1e-6;
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

/// One row's cells by the names in the header.
class Row {
 public:
  Row(const std::vector<std::string_view>& names, std::string_view line, std::string where)
      : names_(names), cells_(csv_cells(line)), where_(std::move(where)) {
    if (cells_.size() == names_.size()) return;
    throw BadInput(
        fmt::format("{}: {} values for {} columns", where_, cells_.size(), names_.size()));
  }

  std::optional<std::string_view> cell(std::string_view name) const {
    const auto found = std::find(names_.begin(), names_.end(), name);
    if (found == names_.end()) return std::nullopt;
    return cells_[static_cast<std::size_t>(found - names_.begin())];
  }

  std::optional<double> number(std::string_view name) const {
    const auto text = cell(name);
    if (!text) return std::nullopt;
    double value = 0;
    const auto [end, error] = std::from_chars(text->data(), text->data() + text->size(), value);
    if (error == std::errc() && end == text->data() + text->size() && std::isfinite(value)) {
      return value;
    }
    throw BadInput(
        fmt::format("{}: '{}' in column {} is not a finite number", where_, *text, name));
  }

  std::optional<Eigen::Vector3d> vector(const std::array<std::string_view, 3>& names) const {
    Eigen::Vector3d v;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto value = number(names[axis]);
      if (!value) return std::nullopt;
      v[static_cast<Eigen::Index>(axis)] = *value;
    }
    return v;
  }

  const std::string& where() const { return where_; }

 private:
  const std::vector<std::string_view>& names_;
  std::vector<std::string_view> cells_;
  std::string where_;
};

int finger_of(const Row& row) {
  const auto cell = row.cell("finger");
  if (!cell || cell->empty()) return -1;
  const auto name = std::find(hand::kFingerNames.begin(), hand::kFingerNames.end(), *cell);
  if (name != hand::kFingerNames.end()) return static_cast<int>(name - hand::kFingerNames.begin());
  int index = -1;  // other names are a hand's own; the search does not need them
  std::from_chars(cell->data(), cell->data() + cell->size(), index);
  return index;
}

tactile::Contact contact_of(const Row& row, const ContactNoise& noise) {
  tactile::Contact contact;
  contact.p = *row.vector({"x", "y", "z"});
  const Eigen::Vector3d n = *row.vector({"nx", "ny", "nz"});
  if (!(n.norm() > kMinNormal)) {
    throw BadInput(fmt::format("{}: a normal of length {}", row.where(), n.norm()));
  }
  contact.n = n.normalized();
  check_plausible(contact.p, kMaxLength,
                  fmt::format("{}: a coordinate in m (is the file in millimetres?)", row.where()));
  contact.time = row.number("t").value_or(0);
  contact.finger = finger_of(row);
  contact.f = row.vector({"fx", "fy", "fz"}).value_or(Eigen::Vector3d::Zero());
  check_plausible(contact.f, kMaxForce, fmt::format("{}: a force", row.where()));
  contact.point_sigma = noise.point;
  contact.normal_sigma = noise.normal;
  return contact;
}

void check_header(const std::vector<std::string_view>& names, std::string_view source) {
  for (std::string_view needed : {"x", "y", "z", "nx", "ny", "nz"}) {
    if (std::find(names.begin(), names.end(), needed) != names.end()) continue;
    throw BadInput(fmt::format("{}:1: no column {} in the header (x,y,z,nx,ny,nz are needed)",
                               source, needed));
  }
}

}  // namespace

std::vector<tactile::Contact> parse_contacts(std::string_view text, std::string_view source,
                                             const ContactNoise& noise) {
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  std::vector<std::string_view> names;
  std::vector<tactile::Contact> contacts;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const auto end = std::min(text.find('\n'), text.size());
    const std::string_view line = trimmed(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.empty()) continue;
    if (names.empty()) {
      names = csv_cells(line);
      check_header(names, source);
    } else {
      contacts.push_back(contact_of({names, line, fmt::format("{}:{}", source, number)}, noise));
    }
  }
  if (names.empty()) throw BadInput(fmt::format("{} is empty: expected a CSV header", source));
  std::stable_sort(contacts.begin(), contacts.end(),
                   [](const auto& a, const auto& b) { return a.time < b.time; });
  return contacts;
}

std::vector<tactile::Contact> read_contacts(const std::filesystem::path& path,
                                            const ContactNoise& noise) {
  return parse_contacts(read_file(path), path.string(), noise);
}

}  // namespace palpate::localization
