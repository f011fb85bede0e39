// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "geometry/io/byte_order.hpp"
#include "geometry/io/mesh_readers.hpp"
#include "geometry/io/mesh_text.hpp"
#include "geometry/mesh/mesh_builder.hpp"
#include "geometry/mesh/weld.hpp"

namespace palpate::geometry {
namespace {

constexpr std::size_t kHeader = 80, kPrefix = kHeader + 4, kFacet = 50;
constexpr std::size_t kNormal = 12;  // bytes of a facet's normal, which its winding determines

std::size_t stated_triangles(std::string_view content) {
  return read_value<std::uint32_t>(content.substr(kHeader));
}

void add_facet(MeshBuilder& builder, std::size_t corners) {
  std::vector<std::int64_t> indices(corners);
  for (std::size_t k = 0; k < corners; ++k) {
    indices[k] = static_cast<std::int64_t>(builder.vertices() - corners + k);
  }
  builder.add_face(indices);
}

void read_binary(std::string_view content, MeshBuilder& builder) {
  const std::size_t triangles = stated_triangles(content);
  for (std::size_t i = 0; i < triangles; ++i) {
    std::string_view facet = content.substr(kPrefix + i * kFacet + kNormal);
    for (int corner = 0; corner < 3; ++corner) {
      Eigen::Vector3d position;
      for (double& coordinate : position) {
        coordinate = read_value<float>(facet);
        facet.remove_prefix(sizeof(float));
      }
      builder.add_vertex(position);
    }
    add_facet(builder, 3);
  }
}

void expect(MeshText& text, std::string_view expected) {
  const std::string_view word = text.next_word();
  if (word != expected) text.fail_at(fmt::format("expected '{}', not", expected), word);
}

/// facet normal nx ny nz / outer loop / vertex x y z (three or more) / endloop / endfacet
void read_facet(MeshText& text, MeshBuilder& builder) {
  expect(text, "normal");
  for (int k = 0; k < 3; ++k) text.next_word();  // some writers put NaN here
  expect(text, "outer");
  expect(text, "loop");
  std::size_t corners = 0;
  std::string_view word = text.next_word();
  for (; word == "vertex"; word = text.next_word()) {
    const double x = text.next_number(), y = text.next_number(), z = text.next_number();
    builder.add_vertex({x, y, z});
    ++corners;
  }
  if (word != "endloop") text.fail_at("expected 'vertex' or 'endloop', not", word);
  expect(text, "endfacet");
  add_facet(builder, corners);
}

/// Goes on to the first line of another solid. @return false at the end of the file
bool begin_solid(MeshText& text) {
  while (auto line = text.next_line()) {
    const std::string_view word = take_word(*line);
    if (word == "solid") return true;
    if (!word.empty()) text.fail_at("expected 'solid' or the end of the file, not", word);
  }
  return false;
}

/// Of a file of several solids all.
void read_ascii(MeshText& text, MeshBuilder& builder) {
  text.next_line();  // solid NAME, of any words
  do {
    for (auto word = text.next_word(); word != "endsolid"; word = text.next_word()) {
      if (word != "facet") text.fail_at("expected 'facet' or 'endsolid', not", word);
      read_facet(text, builder);
    }
  } while (begin_solid(text));
}

}  // namespace

bool is_binary_stl(std::string_view content) {
  return content.size() >= kPrefix &&
         content.size() == kPrefix + kFacet * stated_triangles(content);
}

TriangleMesh read_stl(std::string_view content, std::string_view file) {
  MeshBuilder builder(file);
  if (is_binary_stl(content)) {
    read_binary(content, builder);
  } else if (content.starts_with("solid")) {
    MeshText text(content, file);
    read_ascii(text, builder);
  } else if (content.size() < kPrefix) {
    bad_file(file, fmt::format("STL of {} bytes is shorter than its header", content.size()));
  } else {
    bad_file(file, fmt::format("STL of {} triangles should have {} bytes, not {}",
                               stated_triangles(content),
                               kPrefix + kFacet * stated_triangles(content), content.size()));
  }
  const TriangleMesh soup = std::move(builder).finish();
  return merged(soup, first_at_same_position(soup));
}

}  // namespace palpate::geometry
