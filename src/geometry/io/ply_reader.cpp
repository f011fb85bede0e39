// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "geometry/io/byte_order.hpp"
#include "geometry/io/cloud_readers.hpp"
#include "geometry/io/mesh_readers.hpp"
#include "geometry/io/ply_header.hpp"
#include "geometry/mesh/mesh_builder.hpp"

namespace palpate::geometry {
namespace {

double read_binary(std::string_view bytes, PlyType type, std::endian order) {
  switch (type) {
    case PlyType::kInt8:
      return read_value<std::int8_t>(bytes, order);
    case PlyType::kUint8:
      return read_value<std::uint8_t>(bytes, order);
    case PlyType::kInt16:
      return read_value<std::int16_t>(bytes, order);
    case PlyType::kUint16:
      return read_value<std::uint16_t>(bytes, order);
    case PlyType::kInt32:
      return read_value<std::int32_t>(bytes, order);
    case PlyType::kUint32:
      return read_value<std::uint32_t>(bytes, order);
    case PlyType::kFloat32:
      return static_cast<double>(read_value<float>(bytes, order));
    default:
      return read_value<double>(bytes, order);
  }
}

/// The values after the header, one after another, in any of the formats.
class PlyValues {
 public:
  PlyValues(MeshText& text, PlyFormat format) : text_(text), format_(format), bytes_(text.rest()) {}

  /// Names the element that is read, for messages.
  void enter(const PlyElement& element, std::size_t index) {
    element_ = &element;
    index_ = index;
  }

  double next(PlyType type) {
    if (format_ == PlyFormat::kAscii) return text_.next_number();
    const std::size_t size = size_of(type);
    if (bytes_.size() < size) fail("the file ends too early");
    const auto order = format_ == PlyFormat::kBigEndian ? std::endian::big : std::endian::little;
    const double value = read_binary(bytes_, type, order);
    bytes_.remove_prefix(size);
    return value;
  }

  /// Length of a list. @throws BadInput unless the rest of the file can hold it
  std::size_t next_length(const PlyProperty& list) {
    const double length = next(*list.count_type);
    if (!(length >= 0 && length == std::floor(length) &&
          length <= max_values(smallest_size(list.type)))) {
      fail(fmt::format("a list of {} values does not fit the file", length));
    }
    return static_cast<std::size_t>(length);
  }

  /// @throws BadInput unless the rest of the file can hold the element's count
  void expect_room(const PlyElement& element) {
    std::size_t size = 0;
    for (const auto& property : element.properties) {
      size += smallest_size(property.count_type.value_or(property.type));
    }
    enter(element, 0);
    if (size > 0 && static_cast<double>(element.count) > max_values(size)) {
      fail(fmt::format("the header states {}, more than the file can hold", element.count));
    }
  }

  [[noreturn]] void fail(std::string_view what) const {
    const std::string message = fmt::format("{} {}: {}", element_->name, index_, what);
    if (format_ == PlyFormat::kAscii) text_.fail(message);
    bad_file(text_.file(), message);
  }

 private:
  std::size_t smallest_size(PlyType type) const {
    constexpr std::size_t kDigitAndBlank = 2;
    return format_ == PlyFormat::kAscii ? kDigitAndBlank : size_of(type);
  }

  double max_values(std::size_t size) const {
    const std::size_t left = format_ == PlyFormat::kAscii ? text_.left() + 1 : bytes_.size();
    return static_cast<double>(left / size);
  }

  MeshText& text_;
  PlyFormat format_;
  std::string_view bytes_;
  const PlyElement* element_ = nullptr;
  std::size_t index_ = 0;
};

/// Calls visit({x, y, z, nx, ny, nz}) for every vertex; what the file lacks is nan.
template <class Visit>
void read_vertices(const PlyElement& element, PlyValues& values, const Visit& visit) {
  constexpr std::array<std::string_view, 6> kNames = {"x", "y", "z", "nx", "ny", "nz"};
  for (const std::string_view axis : {"x", "y", "z"}) {
    const auto is_axis = [axis](const auto& p) { return p.name == axis && !p.count_type; };
    if (std::none_of(element.properties.begin(), element.properties.end(), is_axis)) {
      values.fail(fmt::format("the header gives no property '{}'", axis));
    }
  }
  for (std::size_t i = 0; i < element.count; ++i) {
    values.enter(element, i);
    Vector6d vertex = Vector6d::Constant(std::numeric_limits<double>::quiet_NaN());
    for (const auto& property : element.properties) {
      const std::size_t count = property.count_type ? values.next_length(property) : 1;
      for (std::size_t k = 0; k < count; ++k) {
        const double value = values.next(property.type);
        const auto name = std::find(kNames.begin(), kNames.end(), property.name);
        if (name != kNames.end()) vertex[name - kNames.begin()] = value;
      }
    }
    visit(vertex);
  }
}

bool is_corner_list(const PlyProperty& property) {
  return property.count_type &&
         (property.name == "vertex_indices" || property.name == "vertex_index");
}

std::int64_t corner_index(double value, const PlyValues& values) {
  constexpr double kLargest = 2147483647;
  if (!(std::abs(value) <= kLargest && value == std::floor(value))) {
    values.fail(fmt::format("{} is not the index of a vertex", value));
  }
  return static_cast<std::int64_t>(value);
}

/// Passes over a face, or over any element that is not wanted, with `builder` null.
void read_element(const PlyElement& element, PlyValues& values, MeshBuilder* builder) {
  std::vector<std::int64_t> corners;
  for (const auto& property : element.properties) {
    const bool wanted = builder && is_corner_list(property);
    const std::size_t count = property.count_type ? values.next_length(property) : 1;
    for (std::size_t k = 0; k < count; ++k) {
      const double value = values.next(property.type);
      if (wanted) corners.push_back(corner_index(value, values));
    }
    if (wanted) builder->add_face(std::exchange(corners, {}));
  }
}

}  // namespace

TriangleMesh read_ply(std::string_view content, std::string_view file) {
  MeshText text(content, file);
  const PlyHeader header = read_ply_header(text);
  MeshBuilder builder(file);
  PlyValues values(text, header.format);
  for (const auto& element : header.elements) {
    values.expect_room(element);
    if (element.name == "vertex") {
      read_vertices(element, values,
                    [&](const Vector6d& vertex) { builder.add_vertex(vertex.head<3>()); });
      continue;
    }
    const std::size_t count = element.properties.empty() ? 0 : element.count;
    for (std::size_t i = 0; i < count; ++i) {
      values.enter(element, i);
      read_element(element, values, element.name == "face" ? &builder : nullptr);
    }
  }
  return std::move(builder).finish();
}

PointCloud read_ply_cloud(std::string_view content, std::string_view file) {
  MeshText text(content, file);
  const PlyHeader header = read_ply_header(text);
  CloudBuilder builder(file);
  PlyValues values(text, header.format);
  for (const auto& element : header.elements) {
    values.expect_room(element);
    if (element.name == "vertex") {
      read_vertices(element, values, [&](const Vector6d& vertex) { builder.add(vertex); });
      break;
    }
    const std::size_t count = element.properties.empty() ? 0 : element.count;
    for (std::size_t i = 0; i < count; ++i) {
      values.enter(element, i);
      read_element(element, values, nullptr);
    }
  }
  return std::move(builder).finish();
}

}  // namespace palpate::geometry
