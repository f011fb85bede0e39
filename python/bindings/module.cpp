// SPDX-License-Identifier: Apache-2.0
#include <nanobind/stl/string.h>

#include <string>

#include "libraries.hpp"
#include "palpate/core/version.hpp"
#include "robot_parts.hpp"
#include "without_gil.hpp"

NB_MODULE(_core, module) {
  using namespace palpate::python;
  module.doc() =
      "Palpate's compiled libraries. Use them by `import palpate`; SI units, radians, poses (4, 4) "
      "row-major, points (N, 3). Bad input is a ValueError that names the value.";
  module.attr("__version__") = std::string(palpate::version());
  bind_geometry(module);
  bind_registration(module);
  bind_clouds(module);
  bind_hand_description(module);
  bind_hand(module);
  bind_robot_parts(module);
  bind_contacts(module);
  bind_sensors(module);
  bind_normals(module);
  bind_localization(module);
  bind_free_space(module);
  bind_identification(module);
  bind_estimation(module);
  bind_touches(module);
  watch_interpreter_end();
#ifdef NDEBUG
  nanobind::set_leak_warnings(false);  // what a daemon thread holds at the end of the program
#endif
}
