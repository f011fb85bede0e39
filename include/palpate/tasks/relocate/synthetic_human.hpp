// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/core/random.hpp"
#include "palpate/learning/demonstrations/hand_fit.hpp"
#include "palpate/learning/demonstrations/human_sequence.hpp"
#include "palpate/tasks/relocate/relocate_task.hpp"

namespace palpate::relocate {

/// How a synthetic human holds an object: the wrist, and where around the object's axis the
/// fingertips touch. Of a horizontal hand, palm down, with the fingers along +y.
struct SyntheticGrasp {
  double wrist_x = 0.0123, wrist_y = -0.0611, wrist_z = 0.0861;  ///< m, from the object
  double pitch = 0.005, roll = 0.406, yaw = -0.110;  ///< rad: fingers down, thumb up, fingers to -x
  double thumb = 212.3, fingers = 66.3, apart = 29.6;      ///< degrees from +x; between two fingers
  double thumb_height = -0.0198, finger_height = -0.0030;  ///< m, above the object's frame

  template <class Visitor>
  void visit(Visitor&& v) {
    v("wrist_x", wrist_x, -0.3, 0.3, "m, x of the wrist relative to the object");
    v("wrist_y", wrist_y, -0.3, 0.3, "m, y of the wrist relative to the object");
    v("wrist_z", wrist_z, -0.3, 0.3, "m, z of the wrist relative to the object");
    v("pitch", pitch, -1.5, 1.5, "rad, downward pitch of the fingers");
    v("roll", roll, -1.5, 1.5, "rad, upward roll of the thumb");
    v("yaw", yaw, -1.5, 1.5, "rad, yaw of the fingers from -x");
    v("thumb", thumb, 90.0, 360.0, "deg, direction of the thumb's tip about the object, from +x");
    v("fingers", fingers, -90.0, 270.0, "deg, direction of the middle between the fingers' tips");
    v("apart", apart, 0.0, 60.0, "deg, angle between neighbouring fingers");
    v("thumb_height", thumb_height, -0.1, 0.1, "m, height of the thumb above the object's frame");
    v("finger_height", finger_height, -0.1, 0.1,
      "m, height of the fingers above the object's frame");
  }
};

/// How a synthetic human relocates an object. Each sequence varies these at random.
struct SyntheticHumanOptions {
  SyntheticGrasp grasp;
  double rate = 60;             ///< frames per second
  double reach = 0.30;          ///< s to over the object
  double descend = 0.16;        ///< s down to it
  double close = 0.16;          ///< s to close the fingers
  double carry = 0.36;          ///< s to the target
  double hold = 0.5;            ///< s at the target
  double tempo_spread = 0.1;    ///< relative, of these times
  double size_spread = 0.05;    ///< relative, of the hand
  double place_spread = 0.003;  ///< m, of where each fingertip touches
  double noise = 0.0015;        ///< m, of each keypoint's coordinates
  double missing = 0.01;        ///< share of keypoints that are not seen
  double grip_radius = 0.0295;  ///< m, of the object where the fingers hold it

  template <class Visitor>
  void visit(Visitor&& v) {
    v.section("grasp", grasp);
    v("rate", rate, 1.0, 1e4, "Hz, frames per second");
    v("reach", reach, 0.05, 10.0, "s, duration of the reach over the object");
    v("descend", descend, 0.05, 10.0, "s, duration of the descent to the object");
    v("close", close, 0.05, 10.0, "s, duration of the closing of the fingers");
    v("carry", carry, 0.05, 10.0, "s, duration of the carrying to the target");
    v("hold", hold, 0.0, 10.0, "s, duration of the hold at the target");
    v("tempo_spread", tempo_spread, 0.0, 0.3, "relative spread of these durations");
    v("size_spread", size_spread, 0.0, 0.2, "relative spread of the hand's size");
    v("place_spread", place_spread, 0.0, 0.05, "m, spread of the points that the fingertips touch");
    v("noise", noise, 0.0, 0.05, "m, noise of each coordinate of a keypoint");
    v("missing", missing, 0.0, 0.5, "share of keypoints that are not detected");
    v("grip_radius", grip_radius, 0.01, 0.06, "m, radius of the object where the fingers hold it");
  }
};

/// Keypoints and object poses of a person who reaches for an object on a table, grasps it from
/// above and brings it to a target, in world axes: what a camera would see if all were detected.
/// @param object  where the object rests, m
learning::HumanSequence synthetic_relocation(const Eigen::Vector3d& object,
                                             const Eigen::Vector3d& target,
                                             const SyntheticHumanOptions& options,
                                             RandomStream& random);

/// The posture in which a hand of that size holds an object whose axis stands at `object`.
learning::HandState synthetic_grasp(const Eigen::Vector3d& object,
                                    const learning::HumanShape& shape,
                                    const SyntheticHumanOptions& options, RandomStream& random);

}  // namespace palpate::relocate
