// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "localization/scenes.hpp"

namespace palpate::localization {

/// A search for tests that run many.
inline LocalizerOptions quick() {
  LocalizerOptions options;
  options.proposals = 30000;
  options.particles = 600;
  return options;
}

inline bool right(const Posterior& posterior, const geometry::ObjectModel& model,
                  const Scene& scene) {
  return !posterior.modes.empty() &&
         within_tolerance(mode_error(posterior.modes[0], scene.truth, model.object().symmetries));
}

inline Scene scene_of(const std::string& name, SceneOptions options, std::uint64_t seed) {
  return make_scene(model_of(name), options, RandomStream(seed, "scene"));
}

}  // namespace palpate::localization
