// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "common.hpp"
#include "palpate/evaluation/trial.hpp"

namespace palpate::app {

/// An object as a command names it, and what the name stands for.
struct NamedObject {
  std::string name;
  const geometry::KnownObject* object;
};

/// Fingerprint of all that decides how trials go, but for their numbers: version, options, and what
/// is in the files: meshes, and the models of hand and arm.
/// @param candidates  none: each object is known
/// @throws BadInput for a hand or arm that cannot be read
std::string trials_fingerprint(const CommonOptions& common, const evaluation::TrialOptions& options,
                               const std::vector<NamedObject>& objects,
                               const std::vector<NamedObject>& candidates = {});

}  // namespace palpate::app
