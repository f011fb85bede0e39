// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common.hpp"
#include "palpate/registration/cloud_registration.hpp"

namespace palpate::app {

/// What `palpate register --json` prints of a result.
nlohmann::json report_of(const registration::RegistrationResult& result);

/// Prints it for a person.
/// @param has_false_alarms  whether their number was estimated
void print_report(const registration::RegistrationResult& result, const std::string& hint,
                  bool has_false_alarms);

/// Why pairs have no pose, and what may help; empty if they have one or the report says it.
std::string reason_of(const registration::RegistrationResult& result,
                      const registration::RegistrationOptions& options);

/// The same of clouds.
std::string reason_of(const registration::CloudRegistration& registration,
                      const registration::RegistrationOptions& options);

/// How many of the pairs any pose can have, if that is known.
void print_bound(const registration::RegistrationResult& result);

/// What the features of clouds, whose pairs then gave way to nearest neighbours, had to say.
void print_features(const registration::CloudRegistration& registration);

/// The correspondences with weight and residual, as a CSV that `--correspondences` reads.
std::string correspondences_csv(const registration::Correspondences& correspondences,
                                const registration::RegistrationResult& result);

/// One row an iteration: mu, the weighted cost (m^2), then every weight.
std::string weight_history_csv(const std::vector<registration::GncIteration>& history);

}  // namespace palpate::app
