// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include "geometry/io/byte_order.hpp"
#include "geometry/io/cloud_readers.hpp"
#include "geometry/io/lzf.hpp"
#include "geometry/io/mesh_text.hpp"
#include "geometry/mesh/mesh_builder.hpp"

namespace palpate::geometry {
namespace {

struct PcdField {
  std::string name;
  std::size_t size = 4, count = 1;
  char type = 'F';  ///< F, I or U
  std::size_t offset = 0;
};

struct PcdHeader {
  std::vector<PcdField> fields;
  std::size_t points = 0, row = 0;  ///< row: bytes of a point
  std::string data;                 ///< ascii, binary or binary_compressed
};

std::vector<std::string> words_of(std::string_view line) {
  std::vector<std::string> words;
  for (auto word = take_word(line); !word.empty(); word = take_word(line)) words.emplace_back(word);
  return words;
}

std::size_t count_of(const std::string& word, const MeshText& text) {
  const auto number = parse_integer(word);
  if (!number || *number < 0) text.fail_at("expected a count, not", word);
  return static_cast<std::size_t>(*number);
}

/// Sets one property of every field from the words of a header line.
template <class Set>
void for_fields(PcdHeader& header, const std::vector<std::string>& words, const MeshText& text,
                const Set& set) {
  if (words.size() != header.fields.size()) {
    text.fail(fmt::format("{} values for {} fields", words.size(), header.fields.size()));
  }
  for (std::size_t i = 0; i < words.size(); ++i) set(header.fields[i], words[i]);
}

/// @throws BadInput unless so many values of that size are bytes that a row may have
void add_to_row(PcdField& field, std::size_t& row, const MeshText& text) {
  constexpr std::size_t kMaxRow = 1 << 20;  // bytes of a point
  if (field.count == 0 || field.count > kMaxRow || row + field.size * field.count > kMaxRow) {
    text.fail(fmt::format("COUNT {} of the field {} is not in 1..{} bytes of a point", field.count,
                          field.name, kMaxRow));
  }
  field.offset = row;
  row += field.size * field.count;
}

/// @throws BadInput unless what follows the header can hold the points, packed at most 300 to 1
void check_points(const PcdHeader& header, const MeshText& text) {
  constexpr std::size_t kMaxPacking = 300, kMaxPoints = std::size_t{1} << 31;
  const std::size_t bytes = text.rest().size();
  const std::size_t room = header.data == "binary"  ? bytes / header.row
                           : header.data == "ascii" ? bytes / 2 + 1
                                                    : bytes * kMaxPacking / header.row;
  if (header.points > std::min(room, kMaxPoints)) {
    text.fail(
        fmt::format("{} points are more than the file can hold: it ends too early", header.points));
  }
}

void check_header(PcdHeader& header, const MeshText& text) {
  for (auto& field : header.fields) {
    const bool real = field.type == 'F' && (field.size == 4 || field.size == 8);
    const bool whole =
        (field.type == 'I' || field.type == 'U') && field.size >= 1 && field.size <= 8;
    if (!real && !whole) text.fail_at("unknown PCD type of", field.name);
    add_to_row(field, header.row, text);
  }
  for (const char* axis : {"x", "y", "z"}) {
    const auto found = std::ranges::find(header.fields, axis, &PcdField::name);
    if (found == header.fields.end() || found->type != 'F') {
      text.fail_at("the header gives no field of real numbers", axis);
    }
  }
  check_points(header, text);
}

PcdHeader read_header(MeshText& text) {
  PcdHeader header;
  while (auto line = text.next_line()) {
    if (line->starts_with('#')) continue;
    auto words = words_of(*line);
    if (words.empty()) continue;
    const std::string keyword = words.front();
    words.erase(words.begin());
    if (keyword == "FIELDS") {
      for (const auto& word : words) header.fields.push_back({.name = word});
    } else if (keyword == "SIZE") {
      for_fields(header, words, text,
                 [&](PcdField& f, const std::string& word) { f.size = count_of(word, text); });
    } else if (keyword == "TYPE") {
      for_fields(header, words, text,
                 [](PcdField& f, const std::string& word) { f.type = word.front(); });
    } else if (keyword == "COUNT") {
      for_fields(header, words, text,
                 [&](PcdField& f, const std::string& word) { f.count = count_of(word, text); });
    } else if (keyword == "POINTS") {
      header.points = count_of(words.empty() ? "" : words.front(), text);
    } else if (keyword == "DATA") {
      header.data = words.empty() ? "" : words.front();
      check_header(header, text);
      return header;
    }
  }
  text.fail("PCD header without DATA");
}

/// Where x, y, z and the normal stand among the fields; -1 for those that are missing.
std::array<int, 6> columns_of(const PcdHeader& header) {
  constexpr std::array<std::string_view, 6> kNames = {"x",        "y",        "z",
                                                      "normal_x", "normal_y", "normal_z"};
  std::array<int, 6> columns;
  for (std::size_t k = 0; k < 6; ++k) {
    const auto found = std::ranges::find(header.fields, kNames[k], &PcdField::name);
    columns[k] = found == header.fields.end() || found->type != 'F'
                     ? -1
                     : static_cast<int>(found - header.fields.begin());
  }
  return columns;
}

double real_at(std::string_view bytes, std::size_t size) {
  return size == 4 ? static_cast<double>(read_value<float>(bytes)) : read_value<double>(bytes);
}

/// Organised clouds mark rays that hit nothing by nan: they are no points.
void add_unless_missing(CloudBuilder& builder, const Vector6d& point) {
  if (!point.head<3>().array().isNaN().any()) builder.add(point);
}

void read_ascii(const PcdHeader& header, MeshText& text, CloudBuilder& builder) {
  const auto columns = columns_of(header);
  for (std::size_t i = 0; i < header.points; ++i) {
    Vector6d point = Vector6d::Constant(std::nan(""));
    for (std::size_t f = 0; f < header.fields.size(); ++f) {
      for (std::size_t k = 0; k < header.fields[f].count; ++k) {
        const double value = text.next_number();
        const auto column = std::ranges::find(columns, static_cast<int>(f));
        if (column != columns.end()) point[column - columns.begin()] = value;
      }
    }
    add_unless_missing(builder, point);
  }
}

/// @param place  (field, point) -> first byte
template <class Place>
void read_bytes(const PcdHeader& header, std::string_view bytes, CloudBuilder& builder,
                const Place& place) {
  const auto columns = columns_of(header);
  for (std::size_t i = 0; i < header.points; ++i) {
    Vector6d point = Vector6d::Constant(std::nan(""));
    for (std::size_t k = 0; k < 6; ++k) {
      if (columns[k] < 0) continue;
      const PcdField& field = header.fields[static_cast<std::size_t>(columns[k])];
      point[static_cast<Eigen::Index>(k)] = real_at(bytes.substr(place(field, i)), field.size);
    }
    add_unless_missing(builder, point);
  }
}

void read_compressed(const PcdHeader& header, MeshText& text, std::string_view file,
                     CloudBuilder& builder) {
  std::string_view bytes = text.rest();
  if (bytes.size() < 8) bad_file(file, "the file ends too early");
  const auto packed = read_value<std::uint32_t>(bytes);
  const auto unpacked = read_value<std::uint32_t>(bytes.substr(4));
  bytes.remove_prefix(8);
  if (packed > bytes.size() || unpacked != header.points * header.row) {
    bad_file(file, fmt::format("{} compressed bytes for {} of {} points do not fit the file",
                               packed, unpacked, header.points));
  }
  const auto content = lzf_decompress(bytes.substr(0, packed), unpacked);
  if (!content) bad_file(file, "the compressed data is damaged");
  // One field after the other, each for all points.
  read_bytes(header, *content, builder, [&](const PcdField& field, std::size_t i) {
    return field.offset * header.points + i * field.size * field.count;
  });
}

}  // namespace

PointCloud read_pcd(std::string_view content, std::string_view file) {
  MeshText text(content, file);
  const PcdHeader header = read_header(text);
  CloudBuilder builder(file);
  if (header.data == "ascii") {
    read_ascii(header, text, builder);
  } else if (header.data == "binary") {
    read_bytes(header, text.rest(), builder,
               [&](const PcdField& field, std::size_t i) { return i * header.row + field.offset; });
  } else if (header.data == "binary_compressed") {
    read_compressed(header, text, file, builder);
  } else {
    text.fail_at("unknown PCD data", header.data);
  }
  return std::move(builder).finish();
}

}  // namespace palpate::geometry
