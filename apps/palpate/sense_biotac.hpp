// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/recording/recording.hpp"
#include "sense.hpp"

namespace palpate::app {

/// Normals that a trained model finds in a log of a BioTac, judged by the log's own.
/// @throws BadInput without a model
std::vector<SensedStream> sense_biotac(const SenseArguments& arguments);

/// Contacts inferred from the channels of a recording's BioTacs, in the world, by the given or the
/// shipped inverse; one stream a finger, none where the recording has no channels.
/// @throws BadInput for a model and no channels that it could read
std::vector<SensedStream> sense_channels(const SenseArguments& arguments,
                                         const recording::Recording& recording);

}  // namespace palpate::app
