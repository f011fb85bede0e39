// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include "palpate/hand/hand.hpp"

namespace palpate::estimation {

/// Moments of a pick that matter to the estimator.
enum class TouchEvent {
  height_probed,  ///< the flat hand rests on the object's top
  guarded_move,   ///< a fingertip sets out to touch the resting object
  touched,        ///< it touches it
  missed,         ///< it came to the end of its path without contact
  closed,         ///< the fingers have met the object
  held,           ///< the object hangs in the hand, settled
  released,       ///< the hand has released it: what was sensed before no longer holds
  placed,         ///< the object stands where it was put; the hand is about to let go
  probed,         ///< a finger has closed on another spot of the object that the others hold
  on_table,       ///< fingertips rest on the bare table
  opened,         ///< the hand has opened around the object, which has stayed where it was
  table_touched,  ///< the held object has been let down until it touched the table
  fallen,         ///< what has been sensed fell before, or was moved: it may rest in no stable pose
};
inline constexpr std::array<std::string_view, 13> kTouchEventNames = {
    "height_probed", "guarded_move", "touched",  "missed", "closed",        "held",  "released",
    "placed",        "probed",       "on_table", "opened", "table_touched", "fallen"};

/// Whether a guarded move has come to its end.
constexpr bool ends_guarded_move(TouchEvent event) {
  return event == TouchEvent::touched || event == TouchEvent::missed;
}

/// Whether the fingers have come to hold the object, on the table or in the air.
constexpr bool is_grasp(TouchEvent event) {
  return event == TouchEvent::closed || event == TouchEvent::held;
}

/// All that was sensed, and when what was reached: everything that the pose estimate depends on.
struct EventLog {
  struct Moment {
    TouchEvent event;
    std::size_t reading;  ///< index into readings
    bool operator==(const Moment&) const = default;
  };
  std::vector<hand::HandReading> readings;                          ///< one a tick
  std::vector<Moment> moments;                                      ///< in the order of time
  Eigen::Isometry3d T_world_table = Eigen::Isometry3d::Identity();  ///< tilt of the table

  /// Moments since the hand last let go for good.
  std::vector<Moment> since_release() const;

  /// How many moments of a kind there are since then.
  std::size_t count(TouchEvent event) const;

  /// The log up to the latest moment of a kind, with it; all of it where there was none.
  EventLog until(TouchEvent event) const;

  /// Whether the hand has opened and stayed at the object since it let go.
  bool has_opened() const { return since_opening().size() < since_release().size(); }

  /// The log of the grasp before, where since it let go the hand has opened and stayed at the
  /// object.
  std::optional<EventLog> before_opening() const;

  /// Reading of the latest moment of a kind since the hand last let go or opened.
  std::optional<std::size_t> at(TouchEvent event) const;

  /// Whether the object hangs in the hand at a reading, and does not stand on the table: since then
  /// the hand has lifted it, and not put it down.
  bool hangs_at(std::size_t reading) const;

  /// Readings of all moments of a kind since the hand last let go or opened.
  std::vector<std::size_t> all(TouchEvent event) const;

 private:
  std::vector<Moment> since_opening() const;
};

}  // namespace palpate::estimation
