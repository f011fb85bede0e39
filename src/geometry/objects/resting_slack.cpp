// SPDX-License-Identifier: Apache-2.0
#include "palpate/geometry/objects/resting_slack.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "palpate/core/se3.hpp"

namespace palpate::geometry {
namespace {

constexpr int kDirections = 8;  // of half a turn, each looked at to both sides

/// Height of the origin over a plane on which the mesh stands.
double standing_height(const TriangleMesh& mesh, const Eigen::Vector3d& up) {
  double low = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3d& p : mesh.vertices) low = std::min(low, p.dot(up));
  return -low;
}

}  // namespace

RestingSlack::Rises RestingSlack::rises(const TriangleMesh& mesh, const Eigen::Vector3d& up,
                                        const Eigen::Vector3d& direction) {
  const double flat = standing_height(mesh, up);
  Rises rises{};
  for (std::size_t i = 0; i < kLeans.size(); ++i) {
    double least = std::numeric_limits<double>::infinity();
    for (const double side : {-1.0, 1.0}) {
      const Eigen::Vector3d leaning =
          std::cos(kLeans[i]) * up + side * std::sin(kLeans[i]) * direction;
      least = std::min(least, standing_height(mesh, leaning) - flat);
    }
    rises[i] = std::max(i == 0 ? 0.0 : rises[i - 1], least);
  }
  return rises;
}

RestingSlack::RestingSlack(const TriangleMesh& mesh, const StablePose& pose) {
  const Eigen::Vector3d up = pose.R_table_object.row(2).transpose();
  const Eigen::Matrix3d frame = frame_with_z(up);
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kDirections; ++i) {
    const double angle = std::numbers::pi * i / kDirections;
    const Eigen::Vector3d direction =
        std::cos(angle) * frame.col(0) + std::sin(angle) * frame.col(1);
    const Rises found = rises(mesh, up, direction);
    const double sum = found[0] + found[1] + found[2] + found[3];
    if (sum >= least) continue;
    least = sum;
    directions_[0] = direction;
    rises_[0] = found;
  }
  directions_[1] = up.cross(directions_[0]);
  rises_[1] = rises(mesh, up, directions_[1]);
}

double RestingSlack::lean(int direction, double rise) const {
  const Rises& rises = rises_[static_cast<std::size_t>(direction)];
  double lean = 0, risen = 0;
  for (std::size_t i = 0; i < kLeans.size(); ++i) {
    if (rises[i] >= rise) {
      const double share = rises[i] > risen ? (rise - risen) / (rises[i] - risen) : 0;
      return lean + share * (kLeans[i] - lean);
    }
    lean = kLeans[i];
    risen = rises[i];
  }
  return lean;
}

}  // namespace palpate::geometry
