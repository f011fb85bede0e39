// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/estimation/estimate.hpp"

namespace palpate::estimation {

/// Contacts and free space of the guarded moves around the resting object, in the world.
/// @param skipped  guarded moves that are left out, the first ones
localization::Evidence evidence_of_guarded_moves(const hand::HandModel& hand, const EventLog& log,
                                                 const EstimationOptions& options,
                                                 std::size_t skipped);

/// What the closed hand feels at a moment of the log, with what probing and rolling have told
/// since it closed, in its base.
/// @param mass  of the object, kg
/// @return no contacts without the moment
localization::Evidence evidence_in_hand(const hand::HandModel& hand, const EventLog& log,
                                        TouchEvent instant, double mass,
                                        const EstimationOptions& options);

/// Expresses a contact in another frame.
void move(const Eigen::Isometry3d& T_new_old, tactile::Contact& contact);

}  // namespace palpate::estimation
