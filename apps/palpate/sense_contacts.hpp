// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sense.hpp"

namespace palpate::app {

/// Normals and forces of every finger that touches something in a recording of this project. The
/// truth, where the recording has it, is the object's surface nearest to the point touched.
std::vector<SensedStream> sense_recording(const SenseArguments& arguments);

/// Normals and forces of every finger in a CSV of contacts, judged by its own normals.
std::vector<SensedStream> sense_contact_log(const SenseArguments& arguments);

}  // namespace palpate::app
