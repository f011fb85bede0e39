// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/registration/cloud_registration.hpp"

namespace palpate::registration {

/// register_clouds() for several poses of the source, each in the points of the target that the
/// ones before leave over: those farther than the noise bound from the placed source. A pose that
/// explains no more such points than points already taken is none. All but the first are listed as
/// `instances`, those with most pairs first.
CloudRegistration register_instances(const geometry::PointView& source,
                                     const geometry::PointView& target,
                                     const CloudOptions& options);

}  // namespace palpate::registration
