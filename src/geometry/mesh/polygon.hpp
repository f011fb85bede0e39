// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace palpate::geometry {

/// Largest polygon that is taken: triangulation takes quadratic time.
inline constexpr std::size_t kMaxCorners = 1000;

/// Triangles over a nearly flat polygon, of its own winding, by clipping ears in the plane of its
/// area vector (Meisters 1975), the one with the shortest cut first.
///
/// @param loop  indices into vertices, 3 or more
/// @param may_cut  whether a new edge between two vertices is allowed; empty: always
/// @return nothing if no ear is left, as for a loop that crosses itself
std::optional<std::vector<std::array<int, 3>>> clip_ears(
    const std::vector<Eigen::Vector3d>& vertices, std::span<const int> loop,
    const std::function<bool(int, int)>& may_cut = {});

}  // namespace palpate::geometry
