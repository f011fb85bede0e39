// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/estimation/estimate.hpp"

namespace palpate::estimation {

/// Contacts and free space of the guarded moves around the resting object, in the world.
/// @param mass  kg, of the object: a light one is pushed by what touches it
/// @param skipped  guarded moves that are left out, the first ones
localization::Evidence evidence_of_guarded_moves(const hand::Description& hand, const EventLog& log,
                                                 const EstimationOptions& options, double mass,
                                                 std::size_t skipped);

/// A reading of a log, and whether the object hangs in the hand then or stands on the table.
struct Instant {
  std::size_t reading = 0;
  bool hangs = false;
};

/// Contacts of the closed hand at an instant, with those of probing since it closed, in its mount.
/// @param mass  of the object, kg
localization::Evidence evidence_in_hand(const hand::Description& hand, const EventLog& log,
                                        const Instant& instant, double mass,
                                        const EstimationOptions& options);

/// Expresses a contact in another frame.
void transform(const Eigen::Isometry3d& T_new_old, tactile::Contact& contact);

}  // namespace palpate::estimation
