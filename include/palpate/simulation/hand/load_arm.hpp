// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "palpate/hand/arm.hpp"

namespace palpate::simulation {

inline constexpr const char* kFloating = "floating";

/// Which arm carries the hand, where it stands and how the hand is fixed to it.
struct ArmOptions {
  std::string name = kFloating;  ///< "floating", or an installed arm, or its MJCF
  double x = -0.35, y = -0.35;   ///< m, of its stand; it faces the workspace's middle
  double z = 0;                  ///< m, of its stand above the table
  bool hanging = false;          ///< upside down
  /// Of the adapter between flange and hand: rad from the hand's axis behind it to above it.
  double adapter = 0.7853981633974483;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("name", name, "what carries the hand: floating, ur10, ur5, panda, or an arm's MJCF");
    v("x", x, -3.0, 3.0, "m, x of the arm's base");
    v("y", y, -3.0, 3.0, "m, y of the arm's base");
    v("z", z, -1.0, 3.0, "m, height of the arm's base above the table");
    v("hanging", hanging, "mount the arm upside down");
    v("adapter", adapter, 0.0, 1.5707963267948966,
      "rad, angle between the axes of hand and flange: 0: the arm behind the hand, pi/2: above it");
  }
};

/// The arm of an MJCF, with this hand fixed to its flange; none for "floating".
///
/// The flange is the body "attachment", else the site "attachment_site" or "attachment"; the chain
/// goes there from the body of the world that carries it, which is put where the options say: its
/// own position in the file is left out. Of limits of speed an MJCF states nothing: they are those
/// of the maker for the arms that are known by name, else 2 rad/s; accelerations are limited to
/// 15 rad/s^2.
/// @throws BadInput for an unknown name, one that is not installed, or a file without a flange, or
/// with joints other than a chain of hinges up to it, each with a position servo of gear 1
std::optional<hand::ArmDescription> load_arm(const ArmOptions& options,
                                             const hand::Description& hand);

}  // namespace palpate::simulation
