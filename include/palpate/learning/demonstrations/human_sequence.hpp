// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "palpate/learning/demonstrations/human_hand.hpp"

namespace palpate::learning {

/// A hand and an object, seen by a camera frame by frame.
struct HumanSequence {
  std::vector<learning::HandKeypoints> hand;     ///< m; a joint that was not seen is NaN
  std::vector<Eigen::Isometry3d> T_hand_object;  ///< in the frame of the keypoints; may be empty
  double rate = 30;                              ///< frames per second
};

/// Reads keypoints from CSV: a header `frame,j0_x,j0_y,j0_z,...,j20_z`, then a row a frame, m.
/// Frames are whole numbers, each one more than the last. An empty cell or `nan` is a joint that
/// was not seen; so is every joint of a frame in which nothing was seen.
/// @throws BadInput, naming file and line, for anything else; or if there is no frame
std::vector<learning::HandKeypoints> read_keypoints(const std::filesystem::path& path);

/// Reads poses from CSV: a header `frame,T00,T01,...,T23`, the upper rows of a pose row-major;
/// frames as those of keypoints.
/// @throws BadInput, naming file and line, for anything else, a matrix that is no rotation among it
std::vector<Eigen::Isometry3d> read_poses(const std::filesystem::path& path);

struct FilterOptions {
  int skip = 10;            ///< frames at the start, in which a tracker settles
  double stretch = 0.25;    ///< relative change of a bone's length that shows a wrong joint
  double smoothing = 0.02;  ///< s, of the motion: about the time over which it is averaged
  template <class Visitor>
  void visit(Visitor&& v) {
    v("skip", skip, 0, 1000000,
      "frames at the start that are left out, in which a tracker settles");
    v("stretch", stretch, 0.01, 10.0,
      "relative change of a bone's length above which a joint counts as wrong");
    v("smoothing", smoothing, 0.0, 1.0, "s over which the motion is averaged");
  }
};

struct FilteredHand {
  std::vector<learning::HandKeypoints> hand;
  int replaced = 0;  ///< joints that were missing or wrong, and were filled in
};

/// Drops the first frames, replaces joints that are missing or belong to a bone of the wrong length
/// by what lies between their neighbours in time, and smooths the motion.
/// @throws BadInput if nothing is left, or a joint is never right
FilteredHand filter_hand(const std::vector<learning::HandKeypoints>& hand, double rate,
                         const FilterOptions& options = {});

}  // namespace palpate::learning
