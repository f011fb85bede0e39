// SPDX-License-Identifier: Apache-2.0
#include "palpate/simulation/world/world.hpp"

#include <fmt/format.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/string.h>

#include <filesystem>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "bindings/arrays.hpp"
#include "bindings/python_hand.hpp"
#include "bindings/without_gil.hpp"
#include "libraries.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/random.hpp"
#include "palpate/simulation/hand/hand_store.hpp"
#include "palpate/simulation/hand/load_arm.hpp"
#include "palpate/simulation/hand/load_hand.hpp"
#include "palpate/simulation/world/open_loop_grasp.hpp"
#include "picture.hpp"
#include "sized_renderer.hpp"

namespace palpate::python {
namespace {

using namespace nb::literals;

constexpr int kGrasps = 20;             ///< that are tried
constexpr double kCentred = 0.25;       ///< share of the start's spread under an open-loop grasp
constexpr double kGraspYaw = 3;         ///< rad, of the object, about which it is drawn
constexpr double kAboveMiddle = 0.015;  ///< m, of the mount above the object's middle

/// The world's hand, as Python knows hands.
class WorldHand final : public DescribedHand {
 public:
  explicit WorldHand(simulation::World& world) : DescribedHand(world.hand_model()), world_(world) {}
  hand::HandReading step(const hand::HandCommand& command) override {
    const std::lock_guard lock(busy);
    mount = command.mount;
    return world_.hand().step(command);
  }

  hand::MountPosition mount;  ///< as it was commanded last
  std::mutex busy;            ///< threads take turns with the world

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
    const std::lock_guard lock(hand.busy);
    evaluation::start_trial(world, model->object(), start, seed);
    hand.mount = evaluation::waiting_command(world.hand_model()).mount;
  }

  /// Grasps from above, at starts that the seed draws, until the object hangs in the hand.
  hand::HandCommand grasp(std::uint64_t seed) {
    const std::lock_guard lock(hand.busy);
    hand::HandCommand command;
    for (int attempt = 0; attempt < kGrasps; ++attempt) {
      simulation::OpenLoopGrasp grasp;
      grasp.start = evaluation::draw_start(
          model->object(), start,
          RandomStream(seed, "grasp").fork("attempt", static_cast<std::uint64_t>(attempt)).bits());
      grasp.start.xy *= kCentred;
      grasp.start.yaw = kGraspYaw + kCentred * grasp.start.yaw;
      grasp.side = false;
      const auto& rest =
          model->object().stable_poses.at(static_cast<std::size_t>(grasp.start.stable_pose));
      grasp.height = rest.height + kAboveMiddle;
      const bool held = simulation::run_open_loop_grasp(world, grasp, &command);
      hand.mount = command.mount;
      if (held) return command;
    }
    throw std::runtime_error(fmt::format("'{}' fell in {} grasps", model->object().name, kGrasps));
  }

  simulation::Image render(int width, int height) {
    const std::lock_guard lock(hand.busy);
    const simulation::Truth truth = world.truth();
    return renderer.of(width, height, world.hand_model(), model->object())
        .render({truth.T_world_object, truth.joints, hand.mount});
  }

  SharedModel model;
  evaluation::StartOptions start;
  simulation::World world;
  WorldHand hand;
  SizedRenderer renderer;
};

nb::object picture(SimulatedWorld& self, int width, int height) {
  return array_of([&] {
    const WithoutGil release;
    return self.render(width, height);
  }());
}

void make_world(SimulatedWorld* self, nb::object object, const std::string& hand,
                std::uint64_t seed, const nb::dict& settings) {
  evaluation::TrialOptions options = trial_options(settings);
  options.world.hand = hand;
  SharedModel model = object_from(std::move(object));
  const WithoutGil release;
  new (self) SimulatedWorld(std::move(model), options, seed);
}

hand::ArmDescription load_arm(const std::string& name, const hand::Description& hand,
                              const nb::kwargs& mounting) {
  simulation::ArmOptions options;
  apply_settings(mounting, options);
  options.name = name;
  const auto arm = simulation::load_arm(options, hand);
  if (!arm) throw BadInput(fmt::format("'{}' is no arm", name));
  return *arm;
}

void bind_models(nb::module_& module) {
  module.def(
      "load_hand",
      [](const std::filesystem::path& name) {
        const WithoutGil release;
        return simulation::load_hand(name.string());
      },
      "name"_a, nb::sig("def load_hand(name: str | os.PathLike) -> palpate._core.HandDescription"),
      "The description of a hand of `palpate hand list`, or of an MJCF or URDF file. Deriving its "
      "postures takes about a minute; they are kept in the cache.\n\nRaises ValueError if there "
      "is no such hand or its file cannot be used.");
  module.def(
      "install_hand",
      [](const std::string& name) {
        const WithoutGil release;
        return simulation::install_hand(name).string();
      },
      "name"_a,
      "Download the model of a hand of `palpate hand list`, once; returns its file.\n\nRaises "
      "ValueError for a name that is not there, and where it cannot be downloaded.");
  module.def(
      "load_arm", &load_arm, "name"_a, "hand"_a, "mounting"_a,
      nb::sig(
          "def load_arm(name: str, hand: palpate._core.HandDescription, *, x: float = -0.35, y: "
          "float = -0.35, z: float = 0.0, hanging: bool = False, adapter: float = "
          "0.7853981633974483) -> palpate._core.ArmDescription"),
      "The description of an arm, ur10, ur5 or panda once installed, or of an MJCF file, that "
      "carries this hand. x, y, z: m, of its stand, which faces the origin, upside down if "
      "hanging; "
      "adapter: rad, from a flange behind the hand (0) to one above it.\n\nRaises ValueError for "
      "what there is not, a file that is no chain of hinges with a position-controlled actuator "
      "each, and values out of their range.");
}

}  // namespace

evaluation::TrialOptions trial_options(const nb::dict& settings) {
  evaluation::TrialOptions options;
  apply_settings(settings, options);
  return options;
}

SharedModel object_from(nb::object object) {
  if (nb::isinstance<geometry::ObjectModel>(object)) return model_from(std::move(object));
  std::filesystem::path name;
  if (!nb::try_cast(object, name)) {
    throw nb::type_error(fmt::format("object is {}, not a name, a file or a palpate.ObjectModel",
                                     nb::repr(object).c_str())
                             .c_str());
  }
  const WithoutGil release;
  return std::make_shared<const geometry::ObjectModel>(geometry::load_known_object(name.string()));
}

void bind_world(nb::module_& module) {
  bind_models(module);
  module.def("waiting_command", &evaluation::waiting_command, "description"_a,
             nb::sig("def waiting_command(description: palpate._core.HandDescription) -> "
                     "palpate._core.HandCommand"),
             "Where a hand waits before a pick: open, 0.34 m above the table.");
  nb::class_<SimulatedWorld> world(
      module, "World", "A table, an object at its start on it, and a simulated hand above.");
  world
      .def("__init__", &make_world, "object"_a, nb::kw_only(), "hand"_a = "shadow", "seed"_a = 0,
           "options"_a = nb::dict(),
           nb::sig("def __init__(self, object: str | os.PathLike | palpate._core.ObjectModel, *, "
                   "hand: str = "
                   "'shadow', seed: int = 0, options: dict[str, typing.Any] = {}) -> None"),
           "object: a name, a mesh file in metres, or a model; hand: as load_hand() takes it; "
           "options: those of `palpate pick`, as {'start.stable_pose': 0}.\n\nRaises ValueError "
           "for what there is not, and values out of their range.")
      .def("reset", &SimulatedWorld::reset, "seed"_a, nb::call_guard<WithoutGil>(),
           "Puts hand and object, at a start that the seed draws, at rest, at time 0.")
      .def_prop_ro(
          "hand", [](SimulatedWorld& self) -> DescribedHand& { return self.hand; },
          nb::rv_policy::reference_internal, nb::sig("def hand(self) -> palpate._core.Hand"),
          "The simulated hand; its description is off by world.noise.link, as a real one is.")
      .def(
          "truth",
          [](const SimulatedWorld& self) { return pose(self.world.truth().T_world_object); },
          "True T_world_object, (4, 4); for evaluation only.")
      .def_prop_ro(
          "T_world_mount", [](const SimulatedWorld& self) { return pose(self.hand.mount.pose()); },
          "The hand's mount as it was commanded last, (4, 4).")
      .def("grasp", &SimulatedWorld::grasp, "seed"_a, nb::call_guard<WithoutGil>(),
           "Puts the object, at a start that the seed draws, into the Shadow hand by a grasp from "
           "above, lifted by 10 cm; returns the command that holds it.\n\nRaises ValueError for a "
           "hand with other actuators, RuntimeError where the object falls again and again.")
      .def("render", &picture, "width"_a = 480, "height"_a = 360,
           nb::sig("def render(self, width: int = 480, height: int = 360) -> "
                   "numpy.typing.NDArray[numpy.uint8]"),
           "A picture of the scene as it is, (height, width, 3).\n\nRaises ValueError for a size "
           "outside 16 to 4096, and where OpenGL does not work.")
      .def("__repr__", [](const SimulatedWorld& self) {
        return fmt::format("World('{}', hand '{}')", self.model->object().name,
                           self.hand.description().name);
      });
}

}  // namespace palpate::python
