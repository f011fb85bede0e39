// SPDX-License-Identifier: Apache-2.0
#include "geometry/io/mesh_readers.hpp"
#include "geometry/io/mesh_text.hpp"
#include "geometry/mesh/mesh_builder.hpp"

namespace palpate::geometry {
namespace {

Eigen::Vector3d parse_vertex(std::string_view words, const MeshText& text) {
  Eigen::Vector3d position;
  for (double& coordinate : position) {
    const std::string_view word = take_word(words);
    const auto number = parse_number(word);
    if (!number) text.fail_at("expected a coordinate, not", word);
    coordinate = *number;
  }
  return position;
}

/// Index from 0 of "v", "v/vt", "v//vn" or "v/vt/vn", where v counts from 1, or from -1 backwards.
std::int64_t parse_corner(std::string_view word, std::size_t vertices, const MeshText& text) {
  const auto index = parse_integer(word.substr(0, word.find('/')));
  if (!index || *index == 0) text.fail_at("expected the index of a vertex, not", word);
  if (*index > 0) return *index - 1;
  const auto count = static_cast<std::int64_t>(vertices);
  if (*index < -count) text.fail_at("index before the first vertex:", word);
  return count + *index;
}

}  // namespace

TriangleMesh read_obj(std::string_view content, std::string_view file) {
  MeshText text(content, file);
  MeshBuilder builder(file);
  std::vector<std::int64_t> corners;
  while (auto line = text.next_line()) {
    const std::string_view keyword = take_word(*line);
    if (keyword == "v") builder.add_vertex(parse_vertex(*line, text));
    if (keyword != "f") continue;
    corners.clear();
    for (auto word = take_word(*line); !word.empty(); word = take_word(*line)) {
      corners.push_back(parse_corner(word, builder.vertices(), text));
    }
    builder.add_face(corners);
  }
  return std::move(builder).finish();
}

}  // namespace palpate::geometry
