// SPDX-License-Identifier: Apache-2.0
#include "palpate/localization/free_space.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "core/csv_table.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/core/plausible.hpp"

namespace palpate::localization {
namespace {

constexpr double kMaxVoxels = 3e7;  // of a grid, a byte each
constexpr double kOffGrid = 0.05;   // of the pitch, that a center may be beside its voxel's

/// Which cubes of one size are free.
struct Level {
  Eigen::Vector3i size;
  std::vector<char> free;

  [[nodiscard]] std::size_t index(int x, int y, int z) const {
    return (static_cast<std::size_t>(x) * static_cast<std::size_t>(size.y()) +
            static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(size.z()) +
           static_cast<std::size_t>(z);
  }
  [[nodiscard]] bool at(int x, int y, int z) const {
    return x < size.x() && y < size.y() && z < size.z() && free[index(x, y, z)] != 0;
  }

  template <class Visit>
  void for_each(const Visit& visit) const {
    for (int x = 0; x < size.x(); ++x) {
      for (int y = 0; y < size.y(); ++y) {
        for (int z = 0; z < size.z(); ++z) visit(x, y, z);
      }
    }
  }
};

/// Cubes of twice the size, of eight free ones each.
Level joined(const Level& level) {
  Level next{(level.size + Eigen::Vector3i::Ones()) / 2, {}};
  next.free.resize(static_cast<std::size_t>(next.size.cast<Eigen::Index>().prod()));
  next.for_each([&](int x, int y, int z) {
    bool all = true;
    for (int corner = 0; corner < 8; ++corner) {
      all = all && level.at(2 * x + (corner >> 2), 2 * y + (corner >> 1 & 1), 2 * z + (corner & 1));
    }
    next.free[next.index(x, y, z)] = static_cast<char>(all);
  });
  return next;
}

void check(const FreeVoxels& voxels) {
  if (!(std::isfinite(voxels.pitch) && voxels.pitch > 0)) {
    throw BadInput(fmt::format("pitch is {} m, not positive", voxels.pitch));
  }
  const auto count = voxels.size.cast<double>().prod();
  if (voxels.size.minCoeff() < 0 || static_cast<double>(voxels.free.size()) != count) {
    throw BadInput(fmt::format("{} voxels for a grid of {} x {} x {}", voxels.free.size(),
                               voxels.size.x(), voxels.size.y(), voxels.size.z()));
  }
}

FreeSphere sphere_of(const CsvTable& row, const CsvTable::Columns& center, std::size_t radius) {
  const FreeSphere sphere{row.finite(center), row.finite(radius)};
  check_plausible(sphere.center, kMaxLength, row.where() + ": a coordinate in m");
  plausible(sphere.radius, 0, kMaxLength, row.where() + ": a radius in m");
  return sphere;
}

/// Of the rows with center and pitch, in place of the radius.
FreeVoxels grid_of(const std::vector<FreeSphere>& rows, const std::string& source) {
  FreeVoxels grid;
  if (rows.empty()) return grid;
  grid.pitch = rows.front().radius;
  Eigen::AlignedBox3d box;
  for (const FreeSphere& row : rows) box.extend(row.center);
  const Eigen::Array3d cells = (box.sizes().array() / grid.pitch).round() + 1;
  if (!(grid.pitch > 0) || !(cells.prod() <= kMaxVoxels)) {
    throw BadInput(fmt::format("{}: voxels of {} m make a grid of {:.0f} x {:.0f} x {:.0f}", source,
                               grid.pitch, cells.x(), cells.y(), cells.z()));
  }
  grid.size = cells.cast<int>();
  grid.free.resize(static_cast<std::size_t>(cells.prod()));
  grid.T_frame_grid.translation() = box.min().array() - grid.pitch / 2;
  const Level level{grid.size, {}};
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Eigen::Array3d at = (rows[i].center - box.min()).array() / grid.pitch;
    const Eigen::Array3i cell = at.round().cast<int>();
    if ((at - at.round()).abs().maxCoeff() > kOffGrid ||
        std::abs(rows[i].radius - grid.pitch) > kOffGrid * grid.pitch) {
      throw BadInput(fmt::format("{}: voxel {} is not of the grid of {} m that the others make",
                                 source, i, grid.pitch));
    }
    grid.free[level.index(cell.x(), cell.y(), cell.z())] = 1;
  }
  return grid;
}

}  // namespace

std::vector<FreeSphere> free_spheres_of(const FreeVoxels& voxels) {
  check(voxels);
  std::vector<FreeSphere> spheres;
  Level level{voxels.size, voxels.free};
  double size = voxels.pitch;
  while (std::any_of(level.free.begin(), level.free.end(), [](char free) { return free != 0; })) {
    Level next = joined(level);
    level.for_each([&](int x, int y, int z) {
      if (!level.at(x, y, z) || next.at(x / 2, y / 2, z / 2)) return;
      const Eigen::Vector3d center = size * (Eigen::Vector3d(x, y, z).array() + 0.5);
      spheres.push_back({voxels.T_frame_grid * center, size / 2});
    });
    level = std::move(next);
    size *= 2;
  }
  return spheres;
}

std::vector<FreeSphere> read_free_space(const std::filesystem::path& path) {
  const std::string text = read_file(path);
  CsvTable row(text, path.string());
  const CsvTable::Columns center = row.require_xyz("");
  const bool voxels = row.find("size") && !row.find("radius");
  const std::size_t extent = row.require(voxels ? "size" : "radius");
  std::vector<FreeSphere> rows;
  while (row.next()) rows.push_back(sphere_of(row, center, extent));
  return voxels && !rows.empty() ? free_spheres_of(grid_of(rows, path.string())) : rows;
}

}  // namespace palpate::localization
