// SPDX-License-Identifier: Apache-2.0
#include "palpate/geometry/io/point_cloud_io.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "geometry/io/byte_order.hpp"
#include "geometry/io/cloud_readers.hpp"
#include "geometry/io/mesh_readers.hpp"
#include "geometry/io/mesh_text.hpp"
#include "geometry/io/ply_header.hpp"
#include "geometry/mesh/mesh_builder.hpp"
#include "palpate/core/csv.hpp"
#include "palpate/core/file.hpp"
#include "palpate/core/plausible.hpp"
#include "palpate/geometry/io/mesh_io.hpp"
#include "palpate/geometry/mesh/sampling.hpp"

namespace palpate::geometry {
namespace {

bool ply_has_faces(std::string_view content, std::string_view file) {
  MeshText text(content, file);
  const PlyHeader header = read_ply_header(text);
  return std::ranges::any_of(header.elements, [](const PlyElement& element) {
    return element.name == "face" && element.count > 0;
  });
}

/// Vertices of an OBJ without faces; nothing where there is a face.
bool read_obj_cloud(std::string_view content, std::string_view file, CloudBuilder& builder) {
  MeshText text(content, file);
  while (auto line = text.next_line()) {
    const std::string_view keyword = take_word(*line);
    if (keyword == "f") return false;
    if (keyword != "v") continue;
    Vector6d point = Vector6d::Constant(std::nan(""));
    for (int k = 0; k < 3; ++k) {
      const std::string_view word = take_word(*line);
      const auto number = parse_number(word);
      if (!number) text.fail_at("expected a coordinate, not", word);
      point[k] = *number;
    }
    builder.add(point);
  }
  return true;
}

/// Whether blanks and commas both stand between numbers, as where commas are those of decimals.
bool is_mixed(std::string_view line) {
  return line.find(',') != line.npos &&
         std::ranges::any_of(csv_cells(line), [](std::string_view cell) {
           return cell.find_first_of(" \t") != cell.npos;
         });
}

/// The last three of six columns that are not named may also be a colour.
bool is_unit(const Eigen::Vector3d& normal) {
  constexpr double kRounding = 0.1;
  return std::abs(normal.norm() - 1) <= kRounding;
}

PointCloud sampled(const std::filesystem::path& path, std::size_t samples) {
  PointCloud cloud;
  for (const auto& sample :
       sample_surface(load_mesh(path), samples, RandomStream(0, "load_cloud"))) {
    cloud.points.push_back(sample.point);
    cloud.normals.push_back(sample.normal);
  }
  return cloud;
}

}  // namespace

void CloudBuilder::add(const Vector6d& point) {
  if (!point.head<3>().allFinite()) {
    bad_file(file_, fmt::format("point {} is not finite", cloud_.size()));
  }
  if (point.head<3>().cwiseAbs().maxCoeff() > kMaxCoordinate) {
    bad_file(file_,
             fmt::format("point {} is ({}, {}, {})", cloud_.size(), point[0], point[1], point[2]));
  }
  cloud_.points.push_back(point.head<3>());
  const Eigen::Vector3d normal = point.tail<3>();
  all_normals_ = all_normals_ && normal.allFinite() && normal.norm() > 1e-6;
  if (all_normals_) cloud_.normals.push_back(normal.normalized());
}

PointCloud CloudBuilder::finish() && {
  if (!all_normals_) cloud_.normals.clear();
  return std::move(cloud_);
}

PointCloud read_xyz(std::string_view content, std::string_view file) {
  MeshText text(content, file);
  CloudBuilder builder(file);
  while (const auto read = text.next_line()) {
    std::string line(read->substr(0, read->find('#')));
    if (is_mixed(line)) text.fail("blanks and commas between numbers, which need a decimal point");
    std::ranges::replace(line, ',', ' ');
    std::string_view rest = line;
    Vector6d point = Vector6d::Constant(std::nan(""));
    int columns = 0;
    for (auto word = take_word(rest); !word.empty(); word = take_word(rest), ++columns) {
      if (columns >= 6) continue;
      const auto number = parse_number(word);
      if (!number) text.fail_at("expected a number, not", word);
      point[columns] = *number;
    }
    if (columns == 0) continue;
    if (columns < 3) text.fail(fmt::format("{} numbers where a point needs three", columns));
    if (columns != 6 || !is_unit(point.tail<3>())) point.tail<3>().setConstant(std::nan(""));
    builder.add(point);
  }
  return std::move(builder).finish();
}

PointCloud load_cloud(const std::filesystem::path& path, std::size_t samples) {
  const std::string content = read_file(path), file = path.string();
  if (content.empty()) bad_file(file, "empty file");
  const std::string extension = lower_case_extension(path);
  if (extension == ".pcd" || content.starts_with("# .PCD")) return read_pcd(content, file);
  if (extension == ".xyz" || extension == ".txt" || extension == ".pts") {
    return read_xyz(content, file);
  }
  if (content.starts_with("ply") && !ply_has_faces(content, file)) {
    return read_ply_cloud(content, file);
  }
  if (extension == ".obj") {
    CloudBuilder builder(file);
    if (read_obj_cloud(content, file, builder)) return std::move(builder).finish();
  }
  if (extension != ".ply" && extension != ".stl" && extension != ".obj") {
    bad_file(file,
             fmt::format("unknown format '{}': expected PLY, PCD, XYZ, STL or OBJ", extension));
  }
  return sampled(path, samples);
}

void save_cloud(const std::filesystem::path& path, const PointCloud& cloud) {
  check_cloud(cloud);
  std::string bytes = fmt::format(
      "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty double x\n"
      "property double y\nproperty double z\n",
      cloud.size());
  if (cloud.has_normals()) {
    bytes += "property double nx\nproperty double ny\nproperty double nz\n";
  }
  bytes += "end_header\n";
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    for (const double coordinate : cloud.points[i]) append_value(bytes, coordinate);
    if (!cloud.has_normals()) continue;
    for (const double coordinate : cloud.normals[i]) append_value(bytes, coordinate);
  }
  write_file_atomically(path, bytes);
}

}  // namespace palpate::geometry
