// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "palpate/hand/description.hpp"
#include "palpate/tactile/sensors/taxel_layout.hpp"

namespace palpate::ros2 {

/// Topics and frames by which a hand is known. docs/ros2.md has a table of them.
struct RobotInterface {
  std::string joint_states = "/joint_states";
  std::string actuator_states = "/actuator_states";
  std::string contacts = "/contacts";                      ///< "/FINGER" is appended
  std::string fingertip_wrenches = "/fingertip_wrenches";  ///< likewise
  std::string taxels = "/taxels";                          ///< likewise, of raw values
  tactile::TaxelLayout taxel_layout;  ///< where they lie; fingers that are not in it have none
  std::string wrench = "/wrench";     ///< of the mount on the hand, beyond what the hand weighs
  std::string tf = "/tf", tf_static = "/tf_static";
  std::string world = "world", mount = "mount";  ///< frames
  std::string palpate = "/palpate";              ///< before the topics that the estimator writes
  bool best_effort = false;  ///< takes sensor data of senders that send nothing twice, too

  /// Where a finger's contacts are published. Characters that no topic may hold become "_".
  [[nodiscard]] std::string contacts_of(const hand::Finger& finger) const {
    return topic_of(contacts, finger);
  }
  /// Where the wrench on a fingertip is published, in the place of its contacts.
  [[nodiscard]] std::string fingertip_wrench_of(const hand::Finger& finger) const {
    return topic_of(fingertip_wrenches, finger);
  }
  /// Where the raw values of a finger's taxels are published, in the place of its contacts.
  [[nodiscard]] std::string taxels_of(const hand::Finger& finger) const {
    return topic_of(taxels, finger);
  }

 private:
  static std::string topic_of(const std::string& prefix, const hand::Finger& finger) {
    std::string topic = prefix + "/" + finger.name;
    for (char& c : topic) {
      const bool sound = (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') ||
                         (c >= 'a' && c <= 'z') || c == '_' || c == '/';
      if (!sound) c = '_';
    }
    return topic;
  }
};

/// Frame of a finger's contacts: that of its distal link.
inline const std::string& tip_frame(const hand::Description& hand, const hand::Finger& finger) {
  return hand.links[static_cast<std::size_t>(finger.link)].name;
}

}  // namespace palpate::ros2
