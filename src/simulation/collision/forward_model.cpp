// SPDX-License-Identifier: Apache-2.0
#include "palpate/simulation/collision/forward_model.hpp"

#include <cmath>
#include <new>
#include <vector>

#include "palpate/core/error.hpp"
#include "palpate/simulation/collision/collision_scene.hpp"
#include "simulation/hand/believed_hand.hpp"
#include "simulation/world/simulated_hand.hpp"

namespace palpate::simulation {
namespace {

constexpr int kWholeState = mjSTATE_INTEGRATION;

/// Readings are exact, and the servos' small integral, which is no part of the state that can be
/// put back, is left out.
WorldOptions exact_world(const ForwardModelOptions& options) {
  WorldOptions world;
  world.time_step = options.time_step;
  world.hand_friction = options.hand_friction;
  world.table_friction = options.table_friction;
  world.stiffness_scale = options.stiffness_scale;
  world.exact_tips = options.exact_tips;
  world.noise = {0, 0, 0, 0, 0, 0};
  world.integral.limit = 0;
  return world;
}

}  // namespace

struct SimulatedForwardModel::Impl {
  Impl(const geometry::KnownObject& known, const hand::Description& believed,
       const ForwardModelOptions& given)
      : options(exact_world(given)),
        drawn(believed),
        mesh(known.mesh),
        surface(mesh),
        scene(compose_scene(drawn, believed_object(known), surface, options)),
        data(make_data(*scene.model)),
        hand(scene, *data, drawn, options,
             RandomStream(0, "rehearsal")) {  // the text seeds the stream
    place_links(believed, *scene.model);
    mj_setConst(scene.model.get(), data.get());
  }

  skills::RolloutOutcome outcome(const hand::HandReading& reading) const {
    skills::RolloutOutcome result;
    const mjtNum* const position = data->qpos + scene.object_position;
    result.T_mount_object = reading.mount.pose().inverse() * pose3(position, position + 3);
    for (std::size_t finger = 0; finger < reading.contacts.size(); ++finger) {
      for (const auto& contact : reading.contacts[finger]) {
        result.tip_forces[finger] -= contact.f.dot(contact.n);
      }
    }
    result.diverged =
        !result.T_mount_object.matrix().allFinite() || data->warning[mjWARN_BADQACC].number > 0;
    return result;
  }

  WorldOptions options;
  hand::Description drawn;
  geometry::MeshQuery mesh;
  geometry::CapsuleCollider surface;
  Scene scene;
  DataHandle data;
  SimulatedHand hand;
  std::vector<mjtNum> settled;  // state; empty before the first start
};

SimulatedForwardModel::SimulatedForwardModel(const geometry::KnownObject& object,
                                             const hand::Description& believed,
                                             const ForwardModelOptions& options)
    : impl_(std::make_unique<Impl>(object, believed, options)) {}

SimulatedForwardModel::~SimulatedForwardModel() = default;
SimulatedForwardModel::SimulatedForwardModel(SimulatedForwardModel&&) noexcept = default;

skills::RolloutOutcome SimulatedForwardModel::settle(const skills::BelievedGrasp& grasp,
                                                     double seconds) {
  if (!grasp.joints.allFinite() || !grasp.T_world_object.matrix().allFinite()) {
    throw BadInput("a grasp to predict from has a value that is not finite");
  }
  Impl& impl = *impl_;
  const mjModel* const model = impl.scene.model.get();
  mj_resetData(model, impl.data.get());
  impl.hand.reset(grasp.command);
  for (int i = 0; i < impl.drawn.joint_count(); ++i) {
    impl.data->qpos[impl.scene.joint_positions[static_cast<std::size_t>(i)]] = grasp.joints[i];
  }
  mjtNum* const position = impl.data->qpos + impl.scene.object_position;
  write_pose(grasp.T_world_object, position, position + 3);
  mj_forward(model, impl.data.get());
  const auto ticks = std::max(1L, std::lround(seconds / hand::kTick));
  hand::HandReading reading;
  for (long i = 0; i < ticks; ++i) reading = impl.hand.step(grasp.command);
  impl.settled.resize(static_cast<std::size_t>(mj_stateSize(model, kWholeState)));
  mj_getState(model, impl.data.get(), impl.settled.data(), kWholeState);
  return impl.outcome(reading);
}

skills::RolloutOutcome SimulatedForwardModel::rollout(std::span<const hand::HandCommand> motion) {
  Impl& impl = *impl_;
  if (impl.settled.empty() || motion.empty()) {
    throw BadInput("a rollout needs a settled grasp to start from and a motion");
  }
  mj_setState(impl.scene.model.get(), impl.data.get(), impl.settled.data(), kWholeState);
  hand::HandReading reading;
  for (const auto& command : motion) reading = impl.hand.step(command);
  return impl.outcome(reading);
}

std::unique_ptr<planning::CollisionChecker> SimulatedModels::collision_checker(
    const geometry::KnownObject& object, const hand::Description& believed,
    const planning::CollisionOptions& options, const planning::Fixture& fixture) const {
  return std::make_unique<CollisionScene>(object, believed, options, fixture);
}

std::unique_ptr<skills::ForwardModel> SimulatedModels::forward_model(
    const geometry::KnownObject& object, const hand::Description& believed) const {
  return std::make_unique<SimulatedForwardModel>(object, believed, rollouts_);
}

}  // namespace palpate::simulation
