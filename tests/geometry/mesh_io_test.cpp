// SPDX-License-Identifier: Apache-2.0
#include "palpate/geometry/io/mesh_io.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <fstream>

#include "core/temporary_folder.hpp"
#include "geometry/test_meshes.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/core/random.hpp"

namespace palpate::geometry {
namespace {

using testing::box_mesh;
using testing::torus_mesh;

class MeshFiles : public ::testing::Test {
 protected:
  std::filesystem::path write(const std::string& name, std::string_view content) {
    const auto path = folder_.path() / name;
    std::ofstream(path, std::ios::binary) << content;
    return path;
  }

  TriangleMesh load(const std::string& name, std::string_view content) {
    return load_mesh(write(name, content));
  }

  /// The message with which a file is refused, without the folder; empty if it loads.
  std::string refusal(const std::string& name, std::string_view content) {
    try {
      load(name, content);
    } catch (const BadInput& error) {
      std::string message = error.what();
      EXPECT_EQ(message.find('\n'), std::string::npos) << message;
      const auto at = message.find(name);
      EXPECT_NE(at, std::string::npos) << "no file name in: " << message;
      return at == std::string::npos ? message : message.substr(at + name.size());
    }
    return "";
  }

  TemporaryFolder folder_;
};

template <typename T>
void append(std::string& bytes, T value, bool big = false) {
  auto raw = std::bit_cast<std::array<char, sizeof(T)>>(value);
  if (big) std::reverse(raw.begin(), raw.end());  // the tests run on little-endian machines
  bytes.append(raw.data(), raw.size());
}

std::string binary_stl(const TriangleMesh& mesh, std::string header = "binary") {
  header.resize(80, ' ');
  append(header, static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const auto& triangle : mesh.triangles) {
    for (int k = 0; k < 3; ++k) append(header, 0.0F);
    for (const int i : triangle) {
      for (const double x : mesh.vertices[static_cast<std::size_t>(i)]) {
        append(header, static_cast<float>(x));
      }
    }
    append(header, std::uint16_t{7});
  }
  return header;
}

void expect_same(const TriangleMesh& a, const TriangleMesh& b) {
  ASSERT_EQ(a.vertices.size(), b.vertices.size());
  for (std::size_t i = 0; i < a.vertices.size(); ++i) EXPECT_EQ(a.vertices[i], b.vertices[i]);
  EXPECT_EQ(a.triangles, b.triangles);
}

const std::string kAsciiPly =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
    "property float z\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 0\n1 0 0\n0 1 0\n0 0 1\n"
    "3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n";
const std::string kAsciiStl =
    "solid a b c\nfacet normal 0 0 nan\n outer loop\n vertex 0 0 0\n vertex 0 1 0\n"
    " vertex 1e0 0 0\n endloop\nendfacet\nendsolid a b c\n";
const std::string kObj =
    "# comment\nv 0 0 0\nv 1 0 0 0.5\nv 0 1 0\nv 0 0 1\nvt 0 0\nvn 0 0 1\ng part\n"
    "f 1 3 2\nf 1/1 2/1 4/1\nf 2//1 3//1 -1//1\nf 1/1/1 4/1/1 3/1/1\n";

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  const auto at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return text.replace(at, what.size(), by);
}

TEST_F(MeshFiles, SavedPlyRoundTripsExactly) {
  const TriangleMesh mesh = torus_mesh(0.1 / 3, 0.01, 9, 7);
  save_ply(folder_.path() / "mesh.ply", mesh);
  expect_same(load_mesh(folder_.path() / "mesh.ply"), mesh);
  const std::string once = read_file(folder_.path() / "mesh.ply");
  save_ply(folder_.path() / "mesh.ply", mesh);
  EXPECT_EQ(read_file(folder_.path() / "mesh.ply"), once);
}

TEST_F(MeshFiles, AsciiPlyObjAndStlAgree) {
  const TriangleMesh ply = load("a.ply", kAsciiPly);
  ASSERT_EQ(ply.vertices.size(), 4U);
  ASSERT_EQ(ply.triangles.size(), 4U);
  EXPECT_EQ(ply.triangles[2], (std::array<int, 3>{1, 2, 3}));
  expect_same(load("a.obj", kObj), ply);
  const TriangleMesh stl = load("a.STL", kAsciiStl);
  ASSERT_EQ(stl.vertices.size(), 3U);
  EXPECT_EQ(stl.vertices[2], Eigen::Vector3d(1, 0, 0));
}

TEST_F(MeshFiles, AllSolidsOfAnAsciiStlAreRead) {
  const std::string other = replaced(kAsciiStl, "solid a b c", "solid");
  EXPECT_EQ(load("a.stl", kAsciiStl + "\n" + other + "\n").triangles.size(), 2U);
  EXPECT_THROW(load("a.stl", kAsciiStl + "facet normal 0 0 1\n"), BadInput);
  EXPECT_THROW(load("a.stl", kAsciiStl + "solid cut short\n"), BadInput);
}

TEST_F(MeshFiles, AByteOrderMarkDropsNoVertex) {
  const std::string vertices_first = kObj.substr(kObj.find('\n') + 1);
  expect_same(load("a.obj", "\xEF\xBB\xBF" + vertices_first), load("b.obj", kObj));
}

TEST_F(MeshFiles, WindowsLineEndsAreRead) {
  for (const auto& [name, content] : {std::pair("a.ply", kAsciiPly), std::pair("a.obj", kObj)}) {
    std::string windows;
    for (const char c : content) {
      if (c == '\n') windows.push_back('\r');
      windows.push_back(c);
    }
    expect_same(load(name, windows), load("b.ply", kAsciiPly));
  }
}

TEST_F(MeshFiles, BinaryPlyOfBothOrdersWithOtherPropertiesAndPolygons) {
  for (const bool big : {false, true}) {
    std::string bytes = big ? "ply\nformat binary_big" : "ply\nformat binary_little";
    bytes +=
        "_endian 1.0\ncomment c\nelement vertex 4\nproperty uchar red\n"
        "property double x\nproperty float y\nproperty short z\n"
        "element camera 1\nproperty list ushort double pose\n"
        "element face 1\nproperty float quality\n"
        "property list int uint vertex_index\nend_header\n";
    const std::vector<Eigen::Vector3d> square = {{0.1, 0, 0}, {1, 0, 0}, {1, 0.5, -2}, {0, 1, 0}};
    for (const auto& p : square) {
      append(bytes, std::uint8_t{200});
      append(bytes, p.x(), big);
      append(bytes, static_cast<float>(p.y()), big);
      append(bytes, static_cast<std::int16_t>(p.z()), big);
    }
    append(bytes, std::uint16_t{2}, big);
    for (int k = 0; k < 2; ++k) append(bytes, 1.5, big);
    append(bytes, 0.25F, big);
    append(bytes, std::int32_t{4}, big);
    for (const std::uint32_t i : {0U, 1U, 2U, 3U}) append(bytes, i, big);
    const TriangleMesh mesh = load("a.ply", bytes);
    EXPECT_EQ(mesh.vertices, square);
    EXPECT_EQ(mesh.triangles.size(), 2U);
    EXPECT_NE(refusal("a.ply", bytes.substr(0, bytes.size() - 1)), "");
  }
}

TEST_F(MeshFiles, BinaryStlIsWelded) {
  const TriangleMesh box = box_mesh(0.5, 0.25, 2);
  for (const std::string header : {"binary", "solid but binary"}) {
    const TriangleMesh mesh = load("a.stl", binary_stl(box, header));
    EXPECT_EQ(mesh.vertices.size(), 8U);
    EXPECT_EQ(mesh.triangles.size(), 12U);
    EXPECT_NEAR(area(mesh), area(box), 1e-12);
  }
}

TEST_F(MeshFiles, ConcavePolygonKeepsItsArea) {
  const TriangleMesh arrow = load("a.obj", "v 0 0 0\nv 2 -1 0\nv 0 2 0\nv -2 -1 0\nf 1 2 3 4\n");
  EXPECT_EQ(arrow.triangles.size(), 2U);
  EXPECT_NEAR(area(arrow), 4, 1e-12);  // a fan from some corners would cover 8
}

TEST_F(MeshFiles, WhatIsWrongWithAFileIsNamed) {
  const auto expect = [this](const std::string& name, const std::string& content,
                             const std::string& reason) {
    const std::string message = refusal(name, content);
    EXPECT_NE(message.find(reason), std::string::npos) << name << message << " lacks " << reason;
  };
  expect("a.ply", "", "empty");
  expect("a.ply", "hello", "does not begin with 'ply'");
  expect("a.xyz", "hello", "unknown format '.xyz'");
  expect("a.ply", replaced(kAsciiPly, "ascii", "ebcdic"), "line 2: unknown PLY format 'ebcdic'");
  expect("a.ply", replaced(kAsciiPly, "end_header", "end"), "line 9: unknown word");
  expect("a.ply", kAsciiPly.substr(0, 60), "PLY");
  expect("a.ply", replaced(kAsciiPly, "float z", "float w"), "no property 'z'");
  expect("a.ply", replaced(kAsciiPly, "float z", "quad z"), "line 6: unknown PLY type 'quad'");
  expect("a.ply", replaced(kAsciiPly, "vertex 4", "vertex -4"), "line 3");
  expect("a.ply", replaced(kAsciiPly, "vertex 4", "vertex 9000000000"), "states 9000000000");
  expect("a.ply", replaced(kAsciiPly, "1 0 0", "1 nan 0"), "vertex 1 is (1, nan, 0)");
  expect("a.ply", replaced(kAsciiPly, "1 0 0", "1 0 -inf"), "vertex 1 is (1, 0, -inf)");
  expect("a.ply", replaced(kAsciiPly, "1 0 0", "1 x 0"), "line 11: expected a number, not 'x'");
  expect("a.ply", replaced(kAsciiPly, "3 0 3 2", "3 0 4 2"), "face 3 names vertex 4");
  expect("a.ply", replaced(kAsciiPly, "3 0 3 2", "3 0 -1 2"), "face 3 names vertex -1");
  expect("a.ply", replaced(kAsciiPly, "3 0 3 2", "2 0 3 2"), "face 3 has 2 corners");
  expect("a.ply", replaced(kAsciiPly, "3 0 3 2", "9 0 3 2"), "face 3: a list of 9 values");
  expect("a.ply", kAsciiPly.substr(0, kAsciiPly.size() - 4), "3 values does not fit");
  expect("a.ply", replaced(kAsciiPly, "face 4", "face 0"), "no faces");
  expect("a.stl", "short", "STL of 5 bytes");
  const std::string stl = binary_stl(box_mesh(1, 1, 1));
  expect("a.stl", stl.substr(0, stl.size() - 9),
         "STL of 12 triangles should have 684 bytes, not 675");
  expect("a.stl", kAsciiStl.substr(0, 60), "ends too early");
  expect("a.stl", replaced(kAsciiStl, "1e0", "1e999"), "expected a number, not '1e999'");
  expect("a.stl", replaced(kAsciiStl, "1e0", "inf"), "vertex 2 is (inf, 0, 0)");
  expect("a.stl", replaced(kAsciiStl, "endloop", "endlop"), "line 7: expected 'vertex' or");
  expect("a.obj", replaced(kObj, "v 1 0", "v one 0"), "line 3: expected a coordinate, not 'one'");
  expect("a.obj", replaced(kObj, "f 1 3 2", "f 1 3 5"), "face 0 names vertex 4");
  expect("a.obj", replaced(kObj, "f 1 3 2", "f 0 3 2"), "line 9: expected the index");
  expect("a.obj", replaced(kObj, "f 1 3 2", "f 1 3"), "face 0 has 2 corners");
  expect("a.obj", replaced(kObj, "-1//1", "-9//1"), "line 11: index before");
  expect("a.obj", "v 0 0 0\n", "no faces");
  EXPECT_THROW(load_mesh(folder_.path() / "missing.ply"), BadInput);
  EXPECT_THROW(load_mesh(folder_.path()), BadInput);
}

TEST_F(MeshFiles, MessagesHoldNoControlCharacters) {
  const std::string message = refusal("a.obj", "v 0 0 \x1b[31m\x01\n");
  EXPECT_NE(message.find("'?[31m?'"), std::string::npos) << message;
}

/// Whatever is done to a valid file, it loads or is refused in one line.
TEST_F(MeshFiles, DamagedFilesNeverCrash) {
  save_ply(folder_.path() / "good.ply", box_mesh(1, 2, 3));
  const std::vector<std::pair<std::string, std::string>> files = {
      {"a.ply", kAsciiPly},
      {"b.ply", read_file(folder_.path() / "good.ply")},
      {"a.stl", kAsciiStl},
      {"b.stl", binary_stl(box_mesh(1, 2, 3))},
      {"a.obj", kObj}};
  RandomStream random(11);
  int refused = 0, loaded = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    auto [name, content] = files[random.index(files.size())];
    if (random.uniform() < 0.5) content.resize(random.index(content.size()));
    const std::size_t flips = random.index(4);
    for (std::size_t k = 0; k < flips && !content.empty(); ++k) {
      content[random.index(content.size())] = static_cast<char>(random.bits());
    }
    const auto path = write(name, content);
    try {
      const TriangleMesh mesh = load_mesh(path);
      ++loaded;
      for (const auto& vertex : mesh.vertices) ASSERT_TRUE(vertex.allFinite());
      for (const auto& triangle : mesh.triangles) {
        for (const int i : triangle) ASSERT_LT(static_cast<std::size_t>(i), mesh.vertices.size());
      }
    } catch (const BadInput& error) {
      ++refused;
      ASSERT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    }
  }
  EXPECT_GT(refused, 500);
  EXPECT_GT(loaded, 100);
}

}  // namespace
}  // namespace palpate::geometry
