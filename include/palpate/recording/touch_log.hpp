// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "palpate/estimation/event_log.hpp"
#include "palpate/recording/recording.hpp"

namespace palpate::recording {

/// Text of the note that a recording has of a touch event.
std::string touch_note(estimation::TouchEvent event);

/// The touch event that a note of a recording stands for, if it stands for one.
/// @throws BadInput for an event of another name
std::optional<estimation::TouchEvent> touch_event_of(const Event& event);

/// The touch log of a recording: what the estimator needs of it, and nothing of the truth.
estimation::EventLog event_log(const Recording& recording);

}  // namespace palpate::recording
