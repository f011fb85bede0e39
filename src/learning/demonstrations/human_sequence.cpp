// SPDX-License-Identifier: Apache-2.0
#include "palpate/learning/demonstrations/human_sequence.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <limits>
#include <optional>

#include "core/csv_table.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/core/statistics.hpp"
#include "palpate/learning/demonstrations/minimum_jerk.hpp"

namespace palpate::learning {
namespace {

using learning::HandKeypoints;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kRigid = 0.05;  // of R^T R, for rotations that a tracker averaged

std::string keypoint_header() {
  std::string header = "frame";
  for (int joint = 0; joint < learning::kHandKeypoints; ++joint) {
    for (const char axis : {'x', 'y', 'z'}) header += fmt::format(",j{}_{}", joint, axis);
  }
  return header;
}

std::string pose_header() {
  std::string header = "frame";
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) header += fmt::format(",T{}{}", row, column);
  }
  return header;
}

/// Number of the row's frame. @throws BadInput unless it is that after the last one: with frames
/// left out a motion would be too fast
double next_frame(const CsvTable& table, std::optional<double> last) {
  const double frame = table.finite(0);
  if (frame != std::floor(frame)) {
    throw BadInput(fmt::format("{}: frame {} is no whole number", table.where(), frame));
  }
  if (last && frame != *last + 1) {
    throw BadInput(fmt::format(
        "{}: frame {} follows frame {}; each follows the one before, a frame in which nothing was "
        "seen as a row of empty cells",
        table.where(), frame, *last));
  }
  return frame;
}

/// Rows of numbers below a known header, without the frame's number.
/// @param may_miss  whether an empty cell or "nan" is allowed, and becomes NaN
std::vector<std::vector<double>> read_table(const std::filesystem::path& path,
                                            const std::string& header, bool may_miss) {
  const std::string text = read_file(path);
  CsvTable table(text, path.string());
  if (fmt::format("{}", fmt::join(table.names(), ",")) != header) {
    throw BadInput(
        fmt::format("{}:1: the header is not '{}...'", path.string(), header.substr(0, 24)));
  }
  const auto number = [&](std::size_t i) {
    const bool missing = may_miss && (table.cell(i).empty() || table.cell(i) == "nan");
    return missing ? kNan : table.finite(i);
  };
  std::vector<std::vector<double>> rows;
  std::optional<double> frame;
  while (table.next()) {
    frame = next_frame(table, frame);
    rows.emplace_back();
    for (std::size_t i = 1; i < table.names().size(); ++i) rows.back().push_back(number(i));
  }
  if (rows.empty()) throw BadInput(fmt::format("{}: no frame", path.string()));
  return rows;
}

double bone_length(const HandKeypoints& keypoints, const learning::HumanBone& bone) {
  return (keypoints.col(bone.to) - keypoints.col(bone.from)).norm();
}

/// Marks the outer joint of every bone whose length is far from its median as missing.
void drop_wrong_joints(std::vector<HandKeypoints>& frames, double stretch) {
  for (const auto& bone : learning::human_bones()) {
    std::vector<double> lengths;
    for (const auto& frame : frames) {
      const double length = bone_length(frame, bone);
      if (std::isfinite(length)) lengths.push_back(length);
    }
    if (lengths.empty()) continue;
    const double usual = median(lengths);
    for (auto& frame : frames) {
      const double length = bone_length(frame, bone);
      if (!(std::abs(length - usual) <= stretch * usual)) frame.col(bone.to).setConstant(kNan);
    }
  }
}

/// One joint's motion, its gaps bridged, smoothed. @return how many frames were missing
int repair(std::vector<HandKeypoints>& frames, int joint, double rate, double smoothing) {
  std::vector<std::size_t> seen;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (frames[i].col(joint).allFinite()) seen.push_back(i);
  }
  if (seen.empty()) throw BadInput(fmt::format("joint {} of the hand is never right", joint));
  // The ends stay as they were last seen.
  for (std::size_t i = 0; i < seen.front(); ++i)
    frames[i].col(joint) = frames[seen.front()].col(joint);
  for (std::size_t i = seen.back() + 1; i < frames.size(); ++i) {
    frames[i].col(joint) = frames[seen.back()].col(joint);
  }
  const auto missing = static_cast<int>(frames.size() - seen.size());
  seen.insert(seen.begin(), seen.front() > 0 ? 1 : 0, 0);
  if (seen.back() + 1 < frames.size()) seen.push_back(frames.size() - 1);
  Eigen::VectorXd times(std::ssize(seen));
  Eigen::MatrixXd points(3, std::ssize(seen));
  for (std::size_t i = 0; i < seen.size(); ++i) {
    times[static_cast<Eigen::Index>(i)] = static_cast<double>(seen[i]) / rate;
    points.col(static_cast<Eigen::Index>(i)) = frames[seen[i]].col(joint);
  }
  const auto motion = minimum_jerk(times, points, smoothing, 1 / rate);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    frames[i].col(joint) = motion.position.col(static_cast<Eigen::Index>(i));
  }
  return missing;
}

}  // namespace

std::vector<HandKeypoints> read_keypoints(const std::filesystem::path& path) {
  std::vector<HandKeypoints> frames;
  for (const auto& row : read_table(path, keypoint_header(), true)) {
    frames.emplace_back(HandKeypoints::Map(row.data()));
  }
  return frames;
}

std::vector<Eigen::Isometry3d> read_poses(const std::filesystem::path& path) {
  std::vector<Eigen::Isometry3d> poses;
  const auto rows = read_table(path, pose_header(), false);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.matrix().topRows<3>() = Eigen::Matrix<double, 3, 4, Eigen::RowMajor>::Map(rows[i].data());
    const Eigen::Matrix3d R = T.linear();
    if (!((R.transpose() * R - Eigen::Matrix3d::Identity()).norm() < kRigid &&
          R.determinant() > 0)) {
      throw BadInput(fmt::format("{}:{}: not a rotation", path.string(), i + 2));
    }
    T.linear() = Eigen::Quaterniond(R).normalized().toRotationMatrix();
    poses.push_back(T);
  }
  return poses;
}

FilteredHand filter_hand(const std::vector<HandKeypoints>& hand, double rate,
                         const FilterOptions& options) {
  if (!(rate > 0)) throw BadInput(fmt::format("{} frames a second", rate));
  const auto skip = static_cast<std::size_t>(options.skip);
  if (hand.size() <= skip) {
    throw BadInput(fmt::format("{} frames, of which the first {} are skipped", hand.size(), skip));
  }
  FilteredHand result;
  result.hand.assign(hand.begin() + options.skip, hand.end());
  drop_wrong_joints(result.hand, options.stretch);
  for (int joint = 0; joint < learning::kHandKeypoints; ++joint) {
    result.replaced += repair(result.hand, joint, rate, options.smoothing);
  }
  return result;
}

}  // namespace palpate::learning
