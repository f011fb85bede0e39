// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/pick.hpp"

#include <fmt/format.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>

#include <optional>
#include <string>

#include "bindings/arrays.hpp"
#include "bindings/python_hand.hpp"
#include "interruptible.hpp"
#include "pick_result.hpp"

namespace palpate::python {
namespace {

using namespace nb::literals;
using evaluation::TrialOptions;

PickResult pick_in_simulation(SharedModel model, const TrialOptions& options, std::uint64_t seed) {
  evaluation::Trial trial = interruptible([&](std::stop_token stop) {
    return evaluation::run_trial(*model, options, seed, nullptr, {}, std::move(stop));
  });
  return {std::move(trial.result), std::move(model), std::move(trial.events), trial.robot_seconds,
          trial.metrics};
}

/// What step() raised. An exception that is no error, as Ctrl-C, goes on.
nb::object taken(PythonHand& hand) {
  nb::object raised = std::exchange(hand.raised, {});
  if (!raised.is_valid()) return nb::none();
  if (!PyObject_IsInstance(raised.ptr(), PyExc_Exception)) {
    PyErr_SetObject(raised.type().ptr(), raised.ptr());
    throw nb::python_error();
  }
  return raised;
}

/// In the caller's thread: what drives a robot may belong to it.
PickResult pick_with(DescribedHand& hand, SharedModel model, const TrialOptions& options,
                     const std::optional<hand::HandCommand>& start, std::uint64_t seed) {
  auto* const own = dynamic_cast<PythonHand*>(&hand);
  if (own) own->raised = {};
  PickResult result;
  result.model = std::move(model);
  {
    const nb::gil_scoped_release release;
    const hand::HandCommand first =
        start ? *start : evaluation::waiting_command(hand.description());
    skills::Executor robot(hand, hand.description(), first, {}, nullptr, {options.safety, {}});
    result.picked = skills::pick(robot, *result.model, options.pick_options(), seed);
    result.events = evaluation::trial_events(robot.log());
    result.robot_seconds = robot.time();
  }
  if (own) result.raised = taken(*own);
  return result;
}

PickResult pick(nb::object object, nb::object hand, std::uint64_t seed, const nb::dict& settings,
                const std::optional<hand::HandCommand>& start) {
  TrialOptions options = trial_options(settings);
  SharedModel model = object_from(std::move(object));
  if (nb::isinstance<DescribedHand>(hand)) {
    return pick_with(nb::cast<DescribedHand&>(hand), std::move(model), options, start, seed);
  }
  if (!nb::isinstance<nb::str>(hand)) {
    throw nb::type_error(
        fmt::format("hand is {}, not a name, a file or a palpate.Hand", nb::repr(hand).c_str())
            .c_str());
  }
  options.world.hand = nb::cast<std::string>(hand);
  return pick_in_simulation(std::move(model), options, seed);
}

}  // namespace

void bind_pick(nb::module_& module) {
  bind_pick_result(module);
  module.def(
      "pick", &pick, "object"_a = "mug", "hand"_a = "shadow", nb::kw_only(), "seed"_a = 0,
      "options"_a = nb::dict(), "start"_a = nb::none(),
      nb::sig("def pick(object: str | palpate._core.ObjectModel = 'mug', hand: str | "
              "palpate._core.Hand = 'shadow', *, seed: int = 0, options: dict[str, object] = {}, "
              "start: palpate._core.HandCommand | None = None) -> PickResult"),
      "Calibrate, feel, explore, grasp, lift, and estimate the pose, by touch alone.\n\nobject: a "
      "name, a mesh file in metres, or a model; it is within 2 cm of the world's origin, on a "
      "table at height 0. hand: a name or a model file, which is simulated, as `palpate pick` "
      "does; or a Hand of your own, which stands at `start` (waiting_command() unless given) and "
      "is stepped in the caller's thread. options: those of `palpate pick`, as {'lift.height': "
      "0.15}.\n\nWhat fails as expected is in the result; so is a fault of the hand. Raises "
      "ValueError for what there is not, and values out of their range; KeyboardInterrupt once "
      "the hand has been stopped in a safe state.");
}

}  // namespace palpate::python
