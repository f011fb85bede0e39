// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>

#include "palpate/hand/visuals.hpp"
#include "palpate/recording/recording.hpp"

namespace palpate::recording {

/// All that the replay page shows, as viewer/recording.js reads it: plain JSON, long series as
/// base64 of little-endian numbers, poses as x, y, z, qx, qy, qz, qw. Times count from
/// page_origin().
nlohmann::json page_data(const Recording& recording, const hand::HandVisuals& visuals);

/// Meshes, and which link carries which: "meshes", "parts", "spheres", "object_mesh".
nlohmann::json page_shapes(const Recording& recording, const hand::HandVisuals& visuals);

/// Phases, the place for the object, beliefs, and estimates with their errors: "phases",
/// "placement", "beliefs", "estimates".
nlohmann::json page_story(const Recording& recording);

/// Where the page's clock is 0, s: the whole second before the first frame. The page's times are
/// 32-bit numbers, and those of a recording may be of any clock, as seconds since 1970.
double page_origin(double first_frame);
double page_origin(const Recording& recording);

/// Fingers that touch in the frames of a page since the last one that thinning keeps. Where another
/// one touches, the frame is kept as well: a touch may be shorter than those are apart.
class TouchesShown {
 public:
  void begin() { seen_ = 0; }
  /// Takes up a frame. @return whether a finger touches in it that did not since
  bool add(const hand::HandReading& reading);

 private:
  std::uint32_t seen_ = 0;  // a bit a finger
};

// Parts of it, for a page that is shown while they come about.

/// The series of one frame.
nlohmann::json frame_to_json(const Frame& frame, const hand::Description& hand, double origin);
/// "phases", of which those that have not ended last to the time `last`, and "placement".
nlohmann::json events_to_json(const std::vector<Event>& events, double last, double origin);

/// What estimates and beliefs are shown against.
struct PageContext {
  double origin = 0;                  ///< s
  const FrameTruth* truth = nullptr;  ///< at their time, if known, for their errors
  const std::vector<Eigen::Matrix3d>& symmetries;
};
nlohmann::json estimate_to_json(const EstimateRecord& estimate, const PageContext& context);
nlohmann::json belief_to_json(const BeliefRecord& belief, const PageContext& context);
/// Whether a note lists the credible poses of the resting object, and these.
bool holds_belief(const Event& event);
BeliefRecord belief_of(const Event& event);

}  // namespace palpate::recording
