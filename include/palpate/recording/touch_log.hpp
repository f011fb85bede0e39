// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "palpate/estimation/event_log.hpp"
#include "palpate/recording/recording.hpp"

namespace palpate::recording {

/// The moment of a pick that an event marks, if it marks one.
/// @throws BadInput for a mark of another name
std::optional<estimation::TouchEvent> mark_of(const Event& event);

/// The touch log of a recording: what the estimator needs of it, and nothing of the truth.
estimation::EventLog event_log(const Recording& recording);

}  // namespace palpate::recording
