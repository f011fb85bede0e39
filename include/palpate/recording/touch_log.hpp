// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/estimation/event_log.hpp"
#include "palpate/recording/recording.hpp"

namespace palpate::recording {

/// The touch log of a recording: what the estimator needs of it, and nothing of the truth.
estimation::EventLog event_log(const Recording& recording);

}  // namespace palpate::recording
