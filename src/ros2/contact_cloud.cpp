// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>

#include "palpate/core/error.hpp"
#include "palpate/core/plausible.hpp"
#include "palpate/ros2/robot_messages.hpp"

namespace palpate::ros2 {
namespace {

constexpr std::array<std::string_view, 11> kCloudFields = {
    "x",       "y",       "z",       "normal_x",    "normal_y",    "normal_z",
    "force_x", "force_y", "force_z", "point_sigma", "normal_sigma"};
constexpr std::size_t kNeededFields = 3, kMaxPoints = 10000;

using Row = std::array<double, kCloudFields.size()>;

Row row_of(const hand::TipContact& contact) {
  Row row{};
  for (Eigen::Index i = 0; i < 3; ++i) {
    const auto k = static_cast<std::size_t>(i);
    row[k] = contact.p[i];
    row[3 + k] = contact.n[i];
    row[6 + k] = contact.f[i];
  }
  row[9] = contact.point_sigma;
  row[10] = contact.normal_sigma;
  return row;
}

/// Where a field of a point lies.
struct Place {
  std::size_t offset = 0;
  bool wide = false;  ///< 64 bits
};

/// @throws BadInput unless the field is a float within the point
std::optional<Place> place_of(const PointCloud2& cloud, std::string_view name) {
  for (const PointField& field : cloud.point_fields) {
    if (field.name != name) continue;
    const bool wide = field.datatype == PointField::kFloat64;
    const std::size_t size = wide ? sizeof(double) : sizeof(float);
    const bool is_float = wide || field.datatype == PointField::kFloat32;
    if (is_float && std::size_t{field.offset} + size <= cloud.point_step) {
      return Place{field.offset, wide};
    }
    throw BadInput(fmt::format("field {} of type {} at byte {} of points of {} bytes", name,
                               field.datatype, field.offset, cloud.point_step));
  }
  return std::nullopt;
}

double value_at(const std::uint8_t* point, const Place& place) {
  if (place.wide) {
    double value = 0;
    std::memcpy(&value, point + place.offset, sizeof value);
    return value;
  }
  float value = 0;
  std::memcpy(&value, point + place.offset, sizeof value);
  return value;
}

void check_layout(const PointCloud2& cloud) {
  const std::size_t points = std::size_t{cloud.width} * cloud.height;
  const bool fits = cloud.row_step >= std::size_t{cloud.width} * cloud.point_step &&
                    cloud.data.size() >= std::size_t{cloud.row_step} * cloud.height;
  if (points <= kMaxPoints && fits && !cloud.is_bigendian) return;
  throw BadInput(fmt::format(
      "a cloud of {} x {} points of {} bytes, in rows of {} and {} bytes of data, {} endian",
      cloud.height, cloud.width, cloud.point_step, cloud.row_step, cloud.data.size(),
      cloud.is_bigendian ? "big" : "little"));
}

/// Nothing for a point that is not finite.
std::optional<hand::TipContact> contact_of(const Row& row) {
  hand::TipContact contact{{row[0], row[1], row[2]},
                           {row[3], row[4], row[5]},
                           {row[6], row[7], row[8]},
                           row[9],
                           row[10]};
  for (const double value : row) {
    if (!std::isfinite(value)) return std::nullopt;
  }
  check_plausible(contact.p, kMaxLength, "a contact's point");
  check_plausible(contact.f, kMaxForce, "a contact's force");
  plausible(contact.point_sigma, 0, kMaxLength, "a contact's point_sigma");
  plausible(contact.normal_sigma, 0, kMaxAngle, "a contact's normal_sigma");
  const double length = contact.n.norm();
  if (length == 0) return contact;
  plausible(length, 0.9, 1.1, "the length of a contact's normal");
  contact.n /= length;
  return contact;
}

}  // namespace

PointCloud2 cloud_of(const std::vector<hand::TipContact>& contacts, const Header& header) {
  PointCloud2 cloud;
  cloud.header = header;
  cloud.height = 1;
  cloud.width = static_cast<std::uint32_t>(contacts.size());
  for (const std::string_view name : kCloudFields) {
    cloud.point_fields.push_back({std::string(name), cloud.point_step, PointField::kFloat32, 1});
    cloud.point_step += sizeof(float);
  }
  cloud.row_step = cloud.point_step * cloud.width;
  cloud.data.resize(cloud.row_step);
  cloud.is_dense = true;
  std::uint8_t* at = cloud.data.data();
  for (const auto& contact : contacts) {
    for (const double value : row_of(contact)) {
      const auto narrow = static_cast<float>(value);
      std::memcpy(at, &narrow, sizeof narrow);
      at += sizeof narrow;
    }
  }
  return cloud;
}

std::vector<hand::TipContact> contacts_of(const PointCloud2& cloud) {
  check_layout(cloud);
  if (cloud.width == 0 || cloud.height == 0) return {};
  std::array<std::optional<Place>, kCloudFields.size()> places;
  for (std::size_t k = 0; k < places.size(); ++k) {
    places[k] = place_of(cloud, kCloudFields[k]);
    if (k < kNeededFields && !places[k]) {
      throw BadInput(fmt::format("a cloud without the field {}", kCloudFields[k]));
    }
  }
  std::vector<hand::TipContact> contacts;
  for (std::size_t row = 0; row < cloud.height; ++row) {
    for (std::size_t column = 0; column < cloud.width; ++column) {
      const std::uint8_t* point =
          cloud.data.data() + row * cloud.row_step + column * cloud.point_step;
      Row values{};
      for (std::size_t k = 0; k < places.size(); ++k) {
        if (places[k]) values[k] = value_at(point, *places[k]);
      }
      if (const auto contact = contact_of(values)) contacts.push_back(*contact);
    }
  }
  return contacts;
}

}  // namespace palpate::ros2
