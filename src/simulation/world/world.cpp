// SPDX-License-Identifier: Apache-2.0
#include "palpate/simulation/world/world.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "palpate/core/error.hpp"
#include "palpate/core/plausible.hpp"
#include "palpate/simulation/hand/load_hand.hpp"
#include "simulation/hand/warnings.hpp"
#include "simulation/world/drawn_errors.hpp"
#include "simulation/world/simulated_hand.hpp"

namespace palpate::simulation {
namespace {

constexpr double kDropHeight = 0.0005;  // m, above the table at the start
constexpr int kSettleTicks = 1000, kStillTicks = 30;
constexpr double kStillSpeed = 0.001;  // m/s
constexpr double kStillSpin = 0.03;    // rad/s

}  // namespace

struct World::Impl {
  Impl(const geometry::KnownObject& known, const WorldOptions& given, const RandomStream& random,
       const planning::Fixture& fixture)
      : options(with_drawn_friction(given, random)),
        solid(differing_object(believed_object(known), options.error, random)),
        mesh(solid.object.mesh),
        surface(mesh),
        drawn(load_hand(options.hand, options.stiffness_scale)),
        arm(load_arm(options.arm, drawn)),
        scene(compose_scene(drawn, solid, surface, options,
                            {drawn_tilt(options.error, random), fixture, arm ? &*arm : nullptr})),
        data(make_data(*scene.model)),
        believed(believed_hand(drawn, options, random)),
        placing(random.fork("second object")),
        hand(scene, *data, drawn, options, random.fork("readers")) {
    if (arm) hand.mount_on(*arm);
    if (options.biotacs) hand.wear(SimulatedBiotacs(mesh, believed, random.fork("biotacs")));
  }

  void place_object(const Start& start);
  void place_second(const Eigen::Isometry3d& T_table_object);
  [[nodiscard]] bool object_moves() const;

  WorldOptions options;
  SolidObject solid;
  geometry::MeshQuery mesh;
  geometry::CapsuleCollider surface;
  hand::Description drawn;  // as its file has it, and the physics
  std::optional<hand::ArmDescription> arm;
  Scene scene;
  DataHandle data;
  hand::Description believed;
  RandomStream placing;
  SimulatedHand hand;
};

void World::Impl::place_object(const Start& start) {
  const geometry::KnownObject& object = solid.object;
  if (start.stable_pose < 0 || start.stable_pose >= static_cast<int>(object.stable_poses.size())) {
    throw BadInput(fmt::format("object {} has {} stable poses, not number {}", object.name,
                               object.stable_poses.size(), start.stable_pose));
  }
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(start.yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix() *
               object.stable_poses[static_cast<std::size_t>(start.stable_pose)].R_table_object;
  T.translation() << start.xy, kDropHeight - geometry::lowest_point(T, object.mesh);
  mjtNum* const position = data->qpos + scene.object_position;
  write_pose(scene.T_world_table * T, position, position + 3);
  if (options.second_object) place_second(T);
}

/// Beside the object, on a side that is drawn.
void World::Impl::place_second(const Eigen::Isometry3d& T_table_object) {
  RandomStream random = placing;
  const double side = random.uniform(-std::numbers::pi, std::numbers::pi);
  const Eigen::Vector3d out(std::cos(side), std::sin(side), 0);
  double reach = 0;  // of the object to that side
  for (const Eigen::Vector3d& v : solid.object.mesh.vertices) {
    reach = std::max(reach, out.dot(T_table_object.linear() * v));
  }
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(side, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  T.translation() =
      T_table_object.translation() + (reach + options.second_gap + kSecondHalf.x()) * out;
  T.translation().z() = kSecondHalf.z() + kDropHeight;
  mjtNum* const position = data->qpos + scene.second_position;
  write_pose(scene.T_world_table * T, position, position + 3);
}

bool World::Impl::object_moves() const {
  const mjModel& model = *scene.model;
  const mjtNum* const velocity = data->qvel + model.jnt_dofadr[model.body_jntadr[scene.object]];
  return Eigen::Vector3d::Map(velocity).norm() > kStillSpeed ||
         Eigen::Vector3d::Map(velocity + 3).norm() > kStillSpin;
}

World::World(const geometry::KnownObject& object, const WorldOptions& options, std::uint64_t seed,
             const planning::Fixture& fixture)
    : impl_(std::make_unique<Impl>(object, options, RandomStream(seed, "world"), fixture)) {
  silence_warnings();
}

World::~World() = default;

void World::reset(const Start& start, const hand::HandCommand& command) {
  mj_resetData(impl_->scene.model.get(), impl_->data.get());
  impl_->place_object(start);
  impl_->hand.reset(command);
  mj_forward(impl_->scene.model.get(), impl_->data.get());
}

std::optional<Eigen::Vector2d> World::resting_place(const Start& start,
                                                    const hand::HandCommand& waiting) {
  reset(start, waiting);
  int still = 0;
  for (int tick = 0; tick < kSettleTicks && !diverged(); ++tick) {
    impl_->hand.step(waiting);
    still = impl_->object_moves() ? 0 : still + 1;
    if (still < kStillTicks) continue;
    const mjtNum* const position = impl_->data->qpos + impl_->scene.object_position;
    return Eigen::Vector2d(position[0], position[1]);
  }
  return std::nullopt;
}

hand::Hand& World::hand() { return impl_->hand; }

const hand::Description& World::hand_model() const { return impl_->believed; }

Truth World::truth() const {
  const Scene& scene = impl_->scene;
  const mjData& data = *impl_->data;
  Truth truth;
  const mjtNum* const position = data.qpos + scene.object_position;
  truth.T_world_object = pose3(position, position + 3);
  truth.joints.resize(static_cast<Eigen::Index>(scene.joint_positions.size()));
  for (std::size_t i = 0; i < scene.joint_positions.size(); ++i) {
    truth.joints[static_cast<int>(i)] = data.qpos[scene.joint_positions[i]];
  }
  if (impl_->options.corrupted_truth) {
    truth.T_world_object.prerotate(Eigen::AngleAxisd(1, Eigen::Vector3d(1, 2, 2) / 3));
    truth.T_world_object.pretranslate(Eigen::Vector3d(0.1, -0.2, 0.3));
    truth.joints.array() += 0.3;
  }
  truth.T_world_table = scene.T_world_table;
  truth.lowest_point = geometry::lowest_point(scene.T_world_table.inverse() * truth.T_world_object,
                                              impl_->solid.object.mesh);
  return truth;
}

void World::push_object(const Eigen::Vector2d& way, double seconds) {
  const Eigen::Vector2d velocity = way / seconds;
  impl_->hand.push_object({velocity.x(), velocity.y(), 0}, seconds);
}

void World::observe(StepObserver observer) { impl_->hand.observe(std::move(observer)); }

bool World::diverged() const {
  const mjData& data = *impl_->data;
  const auto warned = [&](int kind) { return data.warning[kind].number > 0; };
  const auto positions = Eigen::VectorXd::Map(data.qpos, impl_->scene.model->nq);
  return warned(mjWARN_BADQPOS) || warned(mjWARN_BADQVEL) || warned(mjWARN_BADQACC) ||
         !positions.allFinite() || positions.cwiseAbs().maxCoeff() > kMaxLength;
}

std::string_view simulator_version() { return mj_versionString(); }

}  // namespace palpate::simulation
