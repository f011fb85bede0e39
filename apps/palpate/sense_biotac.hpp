// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sense.hpp"

namespace palpate::app {

/// Normals of a BioTac's log through the model of --model, judged by the log's own normals.
/// @throws BadInput without a model, for a file that is none, or for a log that is none
std::vector<SensedStream> sense_biotac(const SenseArguments& arguments);

}  // namespace palpate::app
