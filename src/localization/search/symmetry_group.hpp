// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <initializer_list>
#include <optional>
#include <vector>

namespace palpate::localization {

/// The rotations that keep an object's shape, as a group that may be continuous.
///
/// geometry::rotational_symmetries lists a shape of revolution by 180 turns or more, and a ball by
/// a covering; no finite group of rotations but those about one line has so many elements. Here
/// such a list stands for all turns about its line, or for all rotations.
class SymmetryGroup {
 public:
  SymmetryGroup(std::initializer_list<Eigen::Quaterniond> rotations)
      : SymmetryGroup(std::vector<Eigen::Quaterniond>(rotations)) {}
  explicit SymmetryGroup(std::vector<Eigen::Quaterniond> rotations);
  explicit SymmetryGroup(const std::vector<Eigen::Matrix3d>& rotations);

  /// The element nearest to a rotation.
  Eigen::Quaterniond nearest(const Eigen::Quaterniond& rotation) const;

  /// The part of a small rotation, about the object's own axes, that changes how the object lies.
  Eigen::Matrix3d seen_rotations() const;

  /// As listed.
  const std::vector<Eigen::Quaterniond>& rotations() const { return rotations_; }

  /// Listed rotations that are turns about one line after a common first rotation.
  struct Turns {
    struct Turn {
      std::size_t index;    ///< in rotations()
      double cosine, sine;  ///< of its angle
    };
    Eigen::Quaterniond line;   ///< the line's direction as a half turn
    Eigen::Quaterniond first;  ///< none, or the turn of the line that comes before
    std::vector<Turn> turns;
  };
  /// All listed rotations of a shape of revolution; none of other shapes.
  const std::vector<Turns>& turns() const { return turns_; }

 private:
  void recognize_continuous();
  void list_turns();
  Eigen::Quaterniond nearest_turn(const Eigen::Quaterniond& rotation) const;

  std::vector<Eigen::Quaterniond> rotations_;
  bool all_ = false;                        // rotations
  std::optional<Eigen::Vector3d> line_;     // all turns about it
  std::optional<Eigen::Quaterniond> flip_;  // that turns the line round
  std::vector<Turns> turns_;
};

}  // namespace palpate::localization
