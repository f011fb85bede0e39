// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "palpate/evaluation/trial.hpp"

namespace palpate::app {

/// Whether an estimate from a recording depends on the option; all others decide what the robot
/// and the world did, which is recorded.
bool is_read_by_replay(std::string_view key, const evaluation::TrialOptions& options);

/// @throws BadInput if the options differ from those that the recording was made with in one that
///         a replay does not read, naming it
void refuse_what_is_recorded(const evaluation::TrialOptions& recorded,
                             const evaluation::TrialOptions& asked, const std::string& recording);

}  // namespace palpate::app
