// SPDX-License-Identifier: Apache-2.0
#include "palpate/simulation/world/world.hpp"

#include <fmt/format.h>
#include <nanobind/stl/string.h>

#include <string>
#include <utility>

#include "bindings/arrays.hpp"
#include "bindings/python_hand.hpp"
#include "palpate/core/options.hpp"
#include "palpate/simulation/hand/load_hand.hpp"
#include "rooms.hpp"

namespace palpate::python {
namespace {

using namespace nb::literals;

/// The world's hand, as Python knows hands.
class WorldHand final : public DescribedHand {
 public:
  explicit WorldHand(simulation::World& world) : DescribedHand(world.hand_model()), world_(world) {}
  hand::HandReading step(const hand::HandCommand& command) override {
    return world_.hand().step(command);
  }

 private:
  simulation::World& world_;
};

/// A world with an object at a start that the seed draws.
struct SimulatedWorld {
  SimulatedWorld(SharedModel object, const evaluation::TrialOptions& trial, std::uint64_t seed)
      : model(std::move(object)),
        start(trial.start),
        world(model->object(), trial.world, seed),
        hand(world) {
    reset(seed);
  }

  void reset(std::uint64_t seed) {
    world.reset(evaluation::draw_start(model->object(), start, seed),
                evaluation::waiting_command(world.hand_model()));
  }

  SharedModel model;
  evaluation::StartOptions start;
  simulation::World world;
  WorldHand hand;
};

void make_world(SimulatedWorld* self, nb::object object, const std::string& hand,
                std::uint64_t seed, const nb::dict& settings) {
  evaluation::TrialOptions options = trial_options(settings);
  options.world.hand = hand;
  SharedModel model = object_from(std::move(object));
  const nb::gil_scoped_release release;
  new (self) SimulatedWorld(std::move(model), options, seed);
}

}  // namespace

evaluation::TrialOptions trial_options(const nb::dict& settings) {
  evaluation::TrialOptions options;
  for (const auto& [key, value] : settings) {
    nb::str text = nb::str(value);
    if (nb::isinstance<nb::bool_>(value)) text = nb::str(nb::cast<bool>(value) ? "true" : "false");
    apply_setting(fmt::format("{}={}", nb::cast<std::string>(key), text.c_str()), options);
  }
  return options;
}

SharedModel object_from(nb::object object) {
  if (nb::isinstance<geometry::ObjectModel>(object)) return model_from(std::move(object));
  if (!nb::isinstance<nb::str>(object)) {
    throw nb::type_error(fmt::format("object is {}, not a name, a file or a palpate.ObjectModel",
                                     nb::repr(object).c_str())
                             .c_str());
  }
  const auto name = nb::cast<std::string>(object);
  const nb::gil_scoped_release release;
  return std::make_shared<const geometry::ObjectModel>(geometry::load_known_object(name));
}

void bind_world(nb::module_& module) {
  module.def(
      "load_hand",
      [](const std::string& name) {
        const nb::gil_scoped_release release;
        return simulation::load_hand(name);
      },
      "name"_a, nb::sig("def load_hand(name: str) -> palpate._core.HandDescription"),
      "The description of a hand of `palpate hand list`, or of an MJCF or URDF file. Deriving its "
      "postures takes about a minute; they are kept in the cache.\n\nRaises ValueError if there "
      "is no such hand or its file cannot be used.");
  module.def("waiting_command", &evaluation::waiting_command, "description"_a,
             nb::sig("def waiting_command(description: palpate._core.HandDescription) -> "
                     "palpate._core.HandCommand"),
             "Where a hand waits before a pick: open, 0.34 m above the table.");
  nb::class_<SimulatedWorld>(module, "World",
                             "A table, an object at its start on it, and a simulated hand above.")
      .def("__init__", &make_world, "object"_a, nb::kw_only(), "hand"_a = "shadow", "seed"_a = 0,
           "options"_a = nb::dict(),
           nb::sig("def __init__(self, object: str | palpate._core.ObjectModel, *, hand: str = "
                   "'shadow', seed: int = 0, options: dict[str, object] = {}) -> None"),
           "object: a name, a mesh file in metres, or a model; hand: as load_hand() takes it; "
           "options: those of `palpate pick`, as {'start.stable_pose': 0}.\n\nRaises ValueError "
           "for what there is not, and values out of their range.")
      .def("reset", &SimulatedWorld::reset, "seed"_a,
           "Puts hand and object, at a start that the seed draws, at rest, at time 0.")
      .def_prop_ro(
          "hand", [](SimulatedWorld& self) -> DescribedHand& { return self.hand; },
          nb::rv_policy::reference_internal, nb::sig("def hand(self) -> palpate._core.Hand"),
          "The simulated hand; its description is off by world.noise.link, as a real one is.")
      .def(
          "truth",
          [](const SimulatedWorld& self) { return pose(self.world.truth().T_world_object); },
          "T_world_object now, (4, 4): what no hand knows; for judging alone.")
      .def("__repr__", [](const SimulatedWorld& self) {
        return fmt::format("World('{}', hand '{}')", self.model->object().name,
                           self.hand.description().name);
      });
}

}  // namespace palpate::python
