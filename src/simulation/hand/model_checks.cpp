// SPDX-License-Identifier: Apache-2.0
#include "simulation/hand/model_checks.hpp"

#include <fmt/format.h>

#include "palpate/core/error.hpp"
#include "simulation/hand/anatomy.hpp"

namespace palpate::simulation {

void check_masses(const mjModel& model) {
  for (int body = 1; body < model.nbody; ++body) {
    if (model.body_mass[body] >= 0) continue;
    throw BadInput(fmt::format("link {} has a mass of {} kg", model_name(model, mjOBJ_BODY, body),
                               model.body_mass[body]));
  }
}

void refuse_closed_loops(const mjModel& model) {
  for (int i = 0; i < model.neq; ++i) {
    if (model.eq_type[i] != mjEQ_CONNECT && model.eq_type[i] != mjEQ_WELD) continue;
    const bool sites = model.eq_objtype[i] == mjOBJ_SITE;
    const auto body = [&](int id) {
      return model_name(model, mjOBJ_BODY, sites ? model.site_bodyid[id] : id);
    };
    throw BadInput(fmt::format("links {} and {} are tied in a closed loop, which is not supported",
                               body(model.eq_obj1id[i]), body(model.eq_obj2id[i])));
  }
}

std::vector<std::string> tendons(const mjModel& model) {
  std::vector<std::string> names;
  for (int i = 0; i < model.ntendon; ++i) names.push_back(model_name(model, mjOBJ_TENDON, i));
  return names;
}

}  // namespace palpate::simulation
