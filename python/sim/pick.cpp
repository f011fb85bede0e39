// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/pick.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bindings/arrays.hpp"
#include "bindings/python_hand.hpp"
#include "bindings/robot_parts.hpp"
#include "bindings/without_gil.hpp"
#include "interruptible.hpp"
#include "palpate/core/error.hpp"
#include "palpate/simulation/collision/forward_model.hpp"
#include "palpate/skills/place/pick_and_place.hpp"
#include "pick_result.hpp"

namespace palpate::python {
namespace {

using namespace nb::literals;
using evaluation::TrialOptions;

PickResult pick_in_simulation(SharedModel model, const TrialOptions& options, std::uint64_t seed) {
  evaluation::Trial trial = interruptible([&](std::stop_token stop) {
    return evaluation::run_trial(*model, options, seed, nullptr, {}, std::move(stop));
  });
  PickResult result{std::move(trial.result), std::move(model), std::move(trial.events),
                    trial.robot_seconds, trial.metrics};
  if (trial.place) result.place = place_result(*trial.place, trial.strategy, trial.place_metrics);
  return result;
}

/// A hand of the user's, and what else it is made of.
struct Robot {
  DescribedHand& hand;
  PythonArm* arm = nullptr;
  std::vector<PythonSensor*> sensors;
  nb::object stop_drives = nb::none();
};

/// Calls what the user gave, from any thread; what it raises is printed.
std::function<void()> stopper(const Robot& robot) {
  if (robot.stop_drives.is_none()) return {};
  return [&robot] {
    const WithGil hold;
    try {
      robot.stop_drives();
    } catch (nb::python_error& error) {
      error.discard_as_unraisable("stop_drives");
    }
  };
}

std::vector<Raised*> raised_of(const Robot& robot) {
  std::vector<Raised*> all;
  if (auto* const own = dynamic_cast<PythonHand*>(&robot.hand)) all.push_back(&own->raised);
  if (robot.arm) all.push_back(&robot.arm->raised);
  for (PythonSensor* const sensor : robot.sensors) all.push_back(&sensor->raised);
  return all;
}

/// What was raised. An exception that is no error, as Ctrl-C, goes on.
nb::object taken(const Robot& robot) {
  nb::object first = nb::none();
  for (Raised* const one : raised_of(robot)) {
    nb::object raised = std::exchange(one->first, {});
    if (!raised.is_valid()) continue;
    if (!PyObject_IsInstance(raised.ptr(), PyExc_Exception)) {
      PyErr_SetObject(raised.type().ptr(), raised.ptr());
      throw nb::python_error();
    }
    if (first.is_none()) first = std::move(raised);
  }
  return first;
}

/// The sensors on their fingers. @throws BadInput for a finger that the hand has not
std::vector<hand::MountedSensor> mounted(const Robot& robot) {
  const auto& fingers = robot.hand.description().fingers;
  std::vector<hand::MountedSensor> sensors;
  for (PythonSensor* const sensor : robot.sensors) {
    const auto on = std::ranges::find(fingers, sensor->finger(), &hand::Finger::name);
    if (on == fingers.end()) {
      std::vector<std::string> names;
      for (const hand::Finger& finger : fingers) names.push_back(finger.name);
      throw BadInput(fmt::format("no finger is called '{}' for a sensor; the hand has {}",
                                 sensor->finger(), fmt::join(names, ", ")));
    }
    sensors.push_back({sensor, static_cast<int>(on - fingers.begin()), sensor->finger()});
  }
  return sensors;
}

/// The target of placing. @throws BadInput as place_target(), and for one that is drawn by how the
/// object starts, which nobody knows of a hand of the user's
std::optional<skills::PlaceTarget> target_of(const geometry::KnownObject& object,
                                             const TrialOptions& options, std::uint64_t seed) {
  if (options.place.target == "stable_pose") {
    throw BadInput(
        "place 'stable_pose' asks how the object starts, known only in simulation: give the pose "
        "(4, 4)");
  }
  return evaluation::place_target(object, options.place, seed, 0);
}

/// Picks, and places where there is a target.
void run(skills::Executor& robot, const TrialOptions& options,
         const std::optional<skills::PlaceTarget>& target, std::uint64_t seed, PickResult& result) {
  const geometry::ObjectModel& object = *result.model;
  const skills::PickOptions pick_options = options.pick_options();
  if (!target) {
    result.picked = skills::pick(robot, object, pick_options, seed);
    return;
  }
  const auto fixture = evaluation::place_fixture(object.object(), options.place, target);
  skills::PickAndPlaceResult outcome = skills::pick_and_place(
      robot, {object, *target, fixture, pick_options, options.place_options(), seed});
  result.picked = std::move(outcome.picked);
  if (outcome.place) result.place = place_result(*outcome.place, outcome.strategy, std::nullopt);
}

/// In the caller's thread: what drives a robot may belong to it.
PickResult pick_with(const Robot& parts, SharedModel model, const TrialOptions& options,
                     const std::optional<hand::HandCommand>& start, std::uint64_t seed) {
  for (Raised* const one : raised_of(parts)) one->first = {};
  PickResult result;
  result.model = std::move(model);
  const std::function<void()> stop_drives = stopper(parts);
  {
    const WithoutGil release;
    const auto target = target_of(result.model->object(), options, seed);
    const simulation::SimulatedModels models(options.forward_model_options());
    hand::AssembledHand hand(parts.hand, parts.arm, mounted(parts),
                             {options.safety.watchdog, options.safety.max_gap});
    const hand::Description& description = parts.hand.description();
    const hand::HandCommand first = start ? *start : evaluation::waiting_command(description);
    skills::Executor robot(hand, description, first, {}, &models,
                           {options.safety, {}, stop_drives});
    run(robot, options, target, seed, result);
    result.events = evaluation::trial_events(robot.log());
    result.robot_seconds = robot.time();
  }
  result.raised = taken(parts);
  return result;
}

/// @throws TypeError for a subclass of palpate.Hand that is not finished
void check_written(nb::handle hand) {
  if (!nb::inst_ready(hand)) {
    throw nb::type_error("the hand's __init__ has to call super().__init__(description)");
  }
  const nb::handle base = nb::type<DescribedHand>();
  const bool own = dynamic_cast<PythonHand*>(nb::inst_ptr<DescribedHand>(hand)) != nullptr;
  if (own && hand.type().attr("step").is(base.attr("step"))) {
    throw nb::type_error("a Hand's step(command) has to be written");
  }
}

/// A target as `palpate pick --place` takes it: its text, (3,) x, y, yaw, or a pose (4, 4).
std::string place_text(nb::handle place) {
  if (nb::isinstance<nb::str>(place)) return nb::cast<std::string>(place);
  const nb::object array =
      nb::module_::import_("numpy").attr("asarray")(place, "dtype"_a = "float");
  std::vector<double> values;
  if (nb::cast<int>(array.attr("ndim")) == 2) {
    const Eigen::Isometry3d T = pose_from(array, "place");
    for (Eigen::Index i = 0; i < 16; ++i) values.push_back(T.matrix()(i / 4, i % 4));
  } else {
    values = numbers_from(array, "place");
    if (values.size() != 3) {
      throw BadInput(fmt::format("place has {} values, not 3: x, y, yaw", values.size()));
    }
  }
  return fmt::format("{}", fmt::join(values, ","));
}

PickResult pick(nb::object object, nb::object hand, std::uint64_t seed, const nb::dict& settings,
                const std::optional<hand::HandCommand>& start, PythonArm* arm,
                std::vector<PythonSensor*> sensors, nb::object place, nb::object stop_drives) {
  TrialOptions options = trial_options(settings);
  if (is_given(stop_drives) && !PyCallable_Check(stop_drives.ptr())) {
    throw nb::type_error("stop_drives is no function");
  }
  if (is_given(place)) options.place.target = place_text(place);
  SharedModel model = object_from(std::move(object));
  if (nb::isinstance<DescribedHand>(hand)) {
    check_written(hand);
    return pick_with(
        {nb::cast<DescribedHand&>(hand), arm, std::move(sensors), std::move(stop_drives)},
        std::move(model), options, start, seed);
  }
  std::filesystem::path name;
  if (!nb::try_cast(hand, name)) {
    throw nb::type_error(
        fmt::format("hand is {}, not a name, a file or a palpate.Hand", nb::repr(hand).c_str())
            .c_str());
  }
  if (arm || !sensors.empty()) {
    throw BadInput(fmt::format(
        "an arm and sensors of your own need a palpate.Hand of your own, not '{}', which is "
        "simulated",
        name.string()));
  }
  if (start) {
    throw BadInput("start needs a palpate.Hand of your own: a simulated one waits above the table");
  }
  if (is_given(stop_drives)) {
    throw BadInput("stop_drives needs a palpate.Hand of your own: a simulated one has no drives");
  }
  options.world.hand = name.string();
  return pick_in_simulation(std::move(model), options, seed);
}

}  // namespace

void bind_pick(nb::module_& module) {
  bind_pick_result(module);
  module.def(
      "pick", &pick, "object"_a = "mug", "hand"_a = "shadow", nb::kw_only(), "seed"_a = 0,
      "options"_a = nb::dict(), "start"_a = nb::none(), "arm"_a = nb::none(),
      "sensors"_a = nb::list(), "place"_a = nb::none(), "stop_drives"_a = nb::none(),
      nb::sig(
          "def pick(object: str | os.PathLike | palpate._core.ObjectModel = 'mug', hand: str | "
          "os.PathLike | "
          "palpate._core.Hand = 'shadow', *, seed: int = 0, options: dict[str, typing.Any] = {}, "
          "start: palpate._core.HandCommand | None = None, arm: palpate._core.Arm | None = None, "
          "sensors: collections.abc.Sequence[palpate._core.Sensor] = [], place: str | "
          "numpy.typing.ArrayLike | None = None, stop_drives: collections.abc.Callable[[], "
          "object] | None = None) -> PickResult"),
      "Calibrates the hand, probes the height, explores, grasps, lifts, and estimates the pose, by "
      "touch alone.\n\nobject: a "
      "name, a mesh file in metres, or a model; it is within 2 cm of the world's origin, on a "
      "table at height 0. hand: a name or a model file, which is simulated, as `palpate pick` "
      "does; or a Hand of your own, which stands at `start` (waiting_command() unless given) and "
      "is stepped in the caller's thread, with the arm that carries it and the sensors on its "
      "fingertips, where they have connections of their own. options: those of `palpate pick`, as "
      "{'lift.height': "
      "0.15}. place: where the object is put down afterwards: a pose (4, 4) of its frame in the "
      "world, (3,) x, y (m) and yaw (rad) standing as it is found, 'random', 'fixture' or, in "
      "simulation, 'stable_pose'. stop_drives: stops the drives of a hand of your own by other "
      "means than step(); called at every fault, and from another thread while step() takes longer "
      "than options={'safety.watchdog': SECONDS}.\n\nWhat fails as expected is in the result; so "
      "is a fault of the robot. Raises "
      "ValueError for what there is not, and values out of their range; KeyboardInterrupt once "
      "the hand has been stopped in a safe state.");
}

}  // namespace palpate::python
