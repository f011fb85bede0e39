// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/tasks/relocate/training/npg.hpp"

namespace palpate::app {

/// Episodes that an expert shows.
relocate::Demonstrations show(const relocate::RelocateModel& model, const relocate::Policy& expert,
                              const relocate::EpisodeOptions& episode, std::uint64_t seed,
                              std::size_t count);

}  // namespace palpate::app
