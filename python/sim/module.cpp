// SPDX-License-Identifier: Apache-2.0
#include "bindings/without_gil.hpp"
#include "libraries.hpp"

NB_MODULE(_sim, module) {
  nanobind::module_::import_("palpate._core");  // the types that both share
  module.doc() = "Palpate's libraries with the simulator. Use them by `import palpate.sim`.";
  palpate::python::bind_world(module);
  palpate::python::bind_pick(module);
  palpate::python::bind_evaluation(module);
  palpate::python::bind_relocate(module);
  palpate::python::bind_plan(module);
  palpate::python::watch_interpreter_end();
}
