// SPDX-License-Identifier: Apache-2.0
#include "palpate/simulation/collision/collision_scene.hpp"

#include <algorithm>
#include <new>
#include <string_view>

#include "palpate/core/error.hpp"
#include "simulation/hand/believed_hand.hpp"
#include "simulation/hand/hand_spec.hpp"
#include "simulation/world/scene.hpp"

namespace palpate::simulation {
namespace {

constexpr double kFarAway = 100;            // m, where an object is out of play
constexpr int kPartAndSurfaceBits = 2 | 8;  // of the object, in the bits of compose_scene

/// A stand-in for the object where there is none: a cube, kept out of play.
geometry::KnownObject stand_in() {
  constexpr double kSide = 0.02;  // m
  geometry::KnownObject cube;
  cube.name = "nothing";
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d corner(i & 1, (i >> 1) & 1, i >> 2);
    cube.mesh.vertices.push_back(kSide * (corner.array() - 0.5));
  }
  cube.mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                         {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  cube.mass = 0.01;
  cube.mass_properties.volume = kSide * kSide * kSide;
  cube.mass_properties.inertia = cube.mass * kSide * kSide / 6 * Eigen::Matrix3d::Identity();
  return cube;
}

std::string palm_body(const hand::Description& hand) {
  return file_link(hand, hand.links[static_cast<std::size_t>(hand.palm)].name);
}

}  // namespace

struct CollisionScene::Impl {
  Impl(const geometry::KnownObject& known, const hand::Description& believed,
       const planning::CollisionOptions& given, const planning::Fixture& fixture, bool object_known)
      : hand(believed),
        options(given),
        has_object(object_known),
        mesh(known.mesh),
        surface(mesh),
        scene(compose_scene(believed, believed_object(known), surface, {}, {.fixture = fixture})),
        data(make_data(*scene.model)),
        palm(find_id(*scene.model, mjOBJ_BODY, palm_body(believed))) {
    place_links(believed, *scene.model);
    place(Eigen::Isometry3d(Eigen::Translation3d(0, 0, kFarAway)));
  }

  void require_object() const {
    if (!has_object) throw BadInput("the scene has no object that could be placed or held");
  }

  void place(const Eigen::Isometry3d& T_world_object) {
    mjtNum* const position = data->qpos + scene.object_position;
    write_pose(T_world_object, position, position + 3);
  }

  void let_hand_meet_object(bool meet);
  void set_hand(const hand::MountPosition& mount, const hand::JointVector& joints);
  bool counts(const mjContact& contact) const;
  std::string name_of(int geom) const;

  hand::Description hand;
  planning::CollisionOptions options;
  bool has_object;
  std::optional<Eigen::Isometry3d> T_palm_object;  // of a held object
  geometry::MeshQuery mesh;
  geometry::CapsuleCollider surface;
  Scene scene;
  DataHandle data;
  int palm;
};

/// Two geoms meet where the type of one and the affinity of the other share a bit; only the hand's
/// and the table's affinities hold the object's bits.
void CollisionScene::Impl::let_hand_meet_object(bool meet) {
  mjModel& m = *scene.model;
  for (int geom = 0; geom < m.ngeom; ++geom) {
    if (scene.stands_fast(geom) || m.geom_bodyid[geom] == scene.object) continue;
    const bool tip = std::find(scene.tips.begin(), scene.tips.end(), geom) != scene.tips.end();
    const int bit = kPartAndSurfaceBits & (tip ? 8 : 2);
    m.geom_conaffinity[geom] =
        meet ? m.geom_conaffinity[geom] | bit : m.geom_conaffinity[geom] & ~bit;
  }
}

void CollisionScene::Impl::set_hand(const hand::MountPosition& mount,
                                    const hand::JointVector& joints) {
  for (int i = 0; i < hand.joint_count(); ++i) {
    data->qpos[scene.joint_positions[static_cast<std::size_t>(i)]] = joints[i];
  }
  for (int i = 0; i < 3; ++i) {
    const auto k = static_cast<std::size_t>(i);
    data->qpos[scene.mount_positions[k]] = mount.xyz[i];
    data->qpos[scene.mount_positions[k + 3]] = mount.ypr[i];
  }
  mj_kinematics(scene.model.get(), data.get());
}

/// That an object at rest touches the table is not the hand's doing.
bool CollisionScene::Impl::counts(const mjContact& contact) const {
  const auto is_other = [&](int geom) {
    return scene.stands_fast(geom) || scene.model->geom_bodyid[geom] == scene.object;
  };
  const int others = is_other(contact.geom[0]) + is_other(contact.geom[1]);
  return others == 2 ? T_palm_object.has_value() : others == 1 || options.self;
}

std::string CollisionScene::Impl::name_of(int geom) const {
  if (geom == scene.table) return "table";
  if (scene.stands_fast(geom)) return "fixture";
  const int body = scene.model->geom_bodyid[geom];
  const int link = scene.links[static_cast<std::size_t>(body)];
  return link < 0 ? "object" : hand.links[static_cast<std::size_t>(link)].name;
}

CollisionScene::CollisionScene(const hand::Description& believed,
                               const planning::CollisionOptions& options)
    : impl_(std::make_unique<Impl>(stand_in(), believed, options, planning::Fixture{}, false)) {}

CollisionScene::CollisionScene(const geometry::KnownObject& object,
                               const hand::Description& believed,
                               const planning::CollisionOptions& options,
                               const planning::Fixture& fixture)
    : impl_(std::make_unique<Impl>(object, believed, options, fixture, true)) {}

const hand::Description& CollisionScene::hand() const { return impl_->hand; }

CollisionScene::~CollisionScene() = default;
CollisionScene::CollisionScene(CollisionScene&&) noexcept = default;
CollisionScene& CollisionScene::operator=(CollisionScene&&) noexcept = default;

void CollisionScene::place(const Eigen::Isometry3d& T_world_object) {
  impl_->require_object();
  impl_->T_palm_object.reset();
  impl_->let_hand_meet_object(true);
  impl_->place(T_world_object);
}

void CollisionScene::hold(const Eigen::Isometry3d& T_palm_object) {
  impl_->require_object();
  impl_->T_palm_object = T_palm_object;
  impl_->let_hand_meet_object(false);
}

Eigen::Isometry3d CollisionScene::palm_pose(const hand::MountPosition& mount,
                                            const hand::JointVector& joints) {
  impl_->set_hand(mount, joints);
  const mjData& data = *impl_->data;
  return pose3(data.xpos + 3 * impl_->palm, data.xquat + 4 * impl_->palm);
}

std::optional<planning::CollidingPair> CollisionScene::deepest_collision(
    const hand::MountPosition& mount, const hand::JointVector& joints) {
  Impl& impl = *impl_;
  impl.set_hand(mount, joints);
  if (impl.T_palm_object) {
    impl.place(palm_pose(mount, joints) * *impl.T_palm_object);
    mj_kinematics(impl.scene.model.get(), impl.data.get());
  }
  mj_collision(impl.scene.model.get(), impl.data.get());
  const mjContact* deepest = nullptr;
  for (int i = 0; i < impl.data->ncon; ++i) {
    const mjContact& contact = impl.data->contact[i];
    if (!impl.counts(contact)) continue;
    if (!deepest || contact.dist < deepest->dist) deepest = &contact;
  }
  if (!deepest || -deepest->dist <= impl.options.allowed_depth) return std::nullopt;
  return planning::CollidingPair{.first = impl.name_of(deepest->geom[0]),
                                 .second = impl.name_of(deepest->geom[1]),
                                 .depth = -deepest->dist};
}

}  // namespace palpate::simulation
