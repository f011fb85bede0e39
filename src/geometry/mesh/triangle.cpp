// SPDX-License-Identifier: Apache-2.0
#include "geometry/mesh/triangle.hpp"

#include <limits>

namespace palpate::geometry {

TrianglePoint closest_point_on_triangle(const Eigen::Vector3d& p, const Corners& t) {
  const Eigen::Vector3d ab = t[1] - t[0], ac = t[2] - t[0], ap = p - t[0];
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return {t[0], Feature::kCorner0};

  const Eigen::Vector3d bp = p - t[1];
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return {t[1], Feature::kCorner1};

  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return {t[0] + d1 / (d1 - d3) * ab, Feature::kEdge0};

  const Eigen::Vector3d cp = p - t[2];
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return {t[2], Feature::kCorner2};

  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return {t[0] + d2 / (d2 - d6) * ac, Feature::kEdge2};

  const double va = d3 * d6 - d5 * d4;
  const double from_b = d4 - d3, from_c = d5 - d6;
  if (va <= 0 && from_b >= 0 && from_c >= 0) {
    return {t[1] + from_b / (from_b + from_c) * (t[2] - t[1]), Feature::kEdge1};
  }
  return {t[0] + (vb * ab + vc * ac) / (va + vb + vc), Feature::kFace};
}

TrianglePoint closest_point_on_edges(const Eigen::Vector3d& p, const Corners& t) {
  TrianglePoint best;
  double best_squared = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const int next = (k + 1) % 3;
    const auto& from = t[static_cast<std::size_t>(k)];
    const Eigen::Vector3d edge = t[static_cast<std::size_t>(next)] - from;
    const double along = (p - from).dot(edge), squared = edge.squaredNorm();
    TrianglePoint here{from, static_cast<Feature>(k)};
    if (along >= squared && squared > 0) {
      here = {t[static_cast<std::size_t>(next)], static_cast<Feature>(next)};
    } else if (along > 0) {
      here = {from + along / squared * edge, static_cast<Feature>(3 + k)};
    }
    const double distance = (p - here.point).squaredNorm();
    if (distance < best_squared) {
      best_squared = distance;
      best = here;
    }
  }
  return best;
}

std::optional<double> line_triangle(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                                    const Corners& t) {
  const Eigen::Vector3d a = t[0] - origin, b = t[1] - origin, c = t[2] - origin;
  const double u = direction.dot(b.cross(c));
  const double v = direction.dot(c.cross(a));
  const double w = direction.dot(a.cross(b));
  if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) return std::nullopt;
  const double sum = u + v + w;
  if (sum == 0) return std::nullopt;  // the line lies in the triangle's plane
  return direction.dot(u * a + v * b + w * c) / (sum * direction.squaredNorm());
}

}  // namespace palpate::geometry
