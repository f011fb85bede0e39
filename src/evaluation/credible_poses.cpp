// SPDX-License-Identifier: Apache-2.0
#include "palpate/evaluation/credible_poses.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "palpate/core/random.hpp"
#include "palpate/core/se3.hpp"

namespace palpate::evaluation {
namespace {

constexpr int kPosesOfAxis = 9;        // of a mode with a free axis
constexpr std::size_t kMaxPoses = 60;  // of a posterior, in a note
constexpr int kPriorPoses = 40;        // before the first touch, about
constexpr double kNotDrawn = 0.003;    // probability below which a pose is left out,
constexpr double kAmongEqual =
    0.3;  // or share of the most probable one's, where all are improbable
constexpr double kCellRadius = localization::PoseTolerance{}.translation;  // m, of a ball of poses
constexpr double kYawCells = 36;        // such balls in a full turn
constexpr double kSameAxis = 1 - 1e-6;  // cosine, of a symmetry that is a turn about the vertical

/// The pose of a mode or, with a free axis, some along it, of equal shares.
void add_poses_of_mode(const localization::Mode& mode, std::vector<CrediblePose>& poses) {
  const int count = mode.free_axis ? kPosesOfAxis : 1;
  for (int i = 0; i < count; ++i) {
    CrediblePose pose{mode.T_frame_object, mode.weight / count};
    if (mode.free_axis) {
      const double angle = mode.free_axis->extent * (2.0 * i / (count - 1) - 1);
      const Eigen::Translation3d to_line(mode.free_axis->point);
      pose.T_frame_object = to_line * Eigen::AngleAxisd(angle, mode.free_axis->direction) *
                            to_line.inverse() * pose.T_frame_object;
    }
    poses.push_back(pose);
  }
}

/// How many poses an object at rest has that are 5 deg and 10 mm apart, as those of a residual set.
double cells_of(const geometry::StablePose& stable, const std::vector<Eigen::Matrix3d>& symmetries,
                double half_width) {
  const Eigen::Vector3d up = stable.R_table_object.transpose().col(2);
  const auto turns = std::ranges::count_if(symmetries, [&](const Eigen::Matrix3d& symmetry) {
    return (symmetry * up).dot(up) > kSameAxis;
  });
  const double yaws = std::max(1.0, kYawCells / static_cast<double>(std::max(turns, 1L)));
  const double side = 2 * half_width;
  return yaws * std::max(1.0, side * side / (std::numbers::pi * kCellRadius * kCellRadius));
}

}  // namespace

std::vector<CrediblePose> credible_poses(const localization::Posterior& posterior,
                                         std::size_t most) {
  std::vector<CrediblePose> poses;
  for (const auto& mode : posterior.modes) add_poses_of_mode(mode, poses);
  for (const auto& T : posterior.residual_set) {
    poses.push_back(
        {T, posterior.residual_mass() / static_cast<double>(posterior.residual_set.size())});
  }
  std::stable_sort(poses.begin(), poses.end(), [](const CrediblePose& a, const CrediblePose& b) {
    return a.probability > b.probability;
  });
  const double least =
      poses.empty() ? 0 : std::min(kNotDrawn, kAmongEqual * poses.front().probability);
  std::erase_if(poses, [&](const CrediblePose& pose) { return pose.probability < least; });
  poses.resize(std::min(poses.size(), most));
  return poses;
}

std::string credible_note(const localization::Posterior& posterior) {
  std::string text = "credible";
  for (const auto& pose : credible_poses(posterior, kMaxPoses)) {
    text += fmt::format(" {:.4g} {:.6g}", pose.probability,
                        fmt::join(pose_to_row_major(pose.T_frame_object), " "));
  }
  return text;
}

std::vector<CrediblePose> prior_poses(const geometry::KnownObject& object,
                                      const estimation::EstimationOptions& options,
                                      const Eigen::Isometry3d& T_world_table) {
  RandomStream random(0, "prior ghosts");
  std::vector<CrediblePose> poses;
  for (const geometry::StablePose& stable : object.stable_poses) {
    const int count = static_cast<int>(std::lround(kPriorPoses * stable.probability));
    const double cells =
        std::max<double>(count, cells_of(stable, object.symmetries, options.resting_half_width));
    for (int i = 0; i < count; ++i) {
      Eigen::Vector3d place(options.place.x(), options.place.y(), stable.height);
      place.x() += random.uniform(-1, 1) * options.resting_half_width;
      place.y() += random.uniform(-1, 1) * options.resting_half_width;
      CrediblePose pose{T_world_table * Eigen::Translation3d(place), stable.probability / cells};
      const Eigen::AngleAxisd yaw(2 * std::numbers::pi * i / count, Eigen::Vector3d::UnitZ());
      pose.T_frame_object.linear() = T_world_table.linear() * yaw * stable.R_table_object;
      poses.push_back(pose);
    }
  }
  return poses;
}

}  // namespace palpate::evaluation
