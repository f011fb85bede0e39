// SPDX-License-Identifier: Apache-2.0
#include "geometry/io/ply_header.hpp"

#include <array>

namespace palpate::geometry {
namespace {

struct TypeNames {
  std::string_view name, sized_name;
  std::size_t size;
};

constexpr std::array<TypeNames, 8> kTypes = {{{"char", "int8", 1},
                                              {"uchar", "uint8", 1},
                                              {"short", "int16", 2},
                                              {"ushort", "uint16", 2},
                                              {"int", "int32", 4},
                                              {"uint", "uint32", 4},
                                              {"float", "float32", 4},
                                              {"double", "float64", 8}}};

PlyType parse_type(std::string_view word, const MeshText& text) {
  for (std::size_t i = 0; i < kTypes.size(); ++i) {
    if (word == kTypes[i].name || word == kTypes[i].sized_name) return static_cast<PlyType>(i);
  }
  text.fail_at("unknown PLY type", word);
}

PlyFormat parse_format(std::string_view word, const MeshText& text) {
  if (word == "ascii") return PlyFormat::kAscii;
  if (word == "binary_little_endian") return PlyFormat::kLittleEndian;
  if (word == "binary_big_endian") return PlyFormat::kBigEndian;
  text.fail_at("unknown PLY format", word);
}

PlyElement parse_element(std::string_view words, const MeshText& text) {
  PlyElement element{std::string(take_word(words)), 0, {}};
  const std::string_view count = take_word(words);
  const auto number = parse_integer(count);
  if (!number || *number < 0) text.fail_at("expected a count of elements, not", count);
  element.count = static_cast<std::size_t>(*number);
  return element;
}

PlyProperty parse_property(std::string_view words, const MeshText& text) {
  PlyProperty property;
  std::string_view type = take_word(words);
  if (type == "list") {
    property.count_type = parse_type(take_word(words), text);
    type = take_word(words);
  }
  property.type = parse_type(type, text);
  property.name = take_word(words);
  return property;
}

}  // namespace

std::size_t size_of(PlyType type) { return kTypes[static_cast<std::size_t>(type)].size; }

PlyHeader read_ply_header(MeshText& text) {
  PlyHeader header;
  bool has_format = false;
  text.next_line();  // "ply"
  while (auto line = text.next_line()) {
    const std::string_view keyword = take_word(*line);
    if (keyword == "end_header") {
      if (!has_format) text.fail("PLY header without a format");
      return header;
    }
    if (keyword == "format") {
      header.format = parse_format(take_word(*line), text);
      has_format = true;
    } else if (keyword == "element") {
      header.elements.push_back(parse_element(*line, text));
    } else if (keyword == "property") {
      if (header.elements.empty()) text.fail("PLY property before any element");
      header.elements.back().properties.push_back(parse_property(*line, text));
    } else if (keyword != "comment" && keyword != "obj_info" && !keyword.empty()) {
      text.fail_at("unknown word in the PLY header:", keyword);
    }
  }
  text.fail("PLY header without end_header");
}

}  // namespace palpate::geometry
