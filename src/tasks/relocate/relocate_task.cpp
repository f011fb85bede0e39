// SPDX-License-Identifier: Apache-2.0
#include "palpate/tasks/relocate/relocate_task.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <new>
#include <string>
#include <tuple>

#include "palpate/core/error.hpp"
#include "tasks/relocate/relocate_model.hpp"

namespace palpate::relocate {
namespace {

constexpr std::array<std::string_view, 3> kSolverNames = {"faithful", "newton", "fast"};

constexpr double kVelocityFilter = 0.5;  // of a new difference of positions in the velocity

/// Whether the physics gave a value that is not finite or too large since the last reset.
bool broken(const mjData& data) {
  return data.warning[mjWARN_BADQPOS].number > 0 || data.warning[mjWARN_BADQVEL].number > 0 ||
         data.warning[mjWARN_BADQACC].number > 0;
}

struct Distances {
  double palm_object, palm_target, object_target;
};

/// Reward of the published task (DexMV, relocation).
double reward(const Distances& d, bool contact, double lift) {
  double sum = -0.1 * d.palm_object;
  if (!contact) return sum;
  sum += 0.1 + 50 * lift;
  if (lift <= 0.015) return sum;
  sum += 2 - 0.5 * d.palm_target - 1.5 * d.object_target;
  return d.object_target < 0.1 ? sum + 1 / (d.object_target + 0.01) : sum;
}

}  // namespace

RelocateSolver relocate_solver(std::string_view name) {
  const auto* const found = std::find(kSolverNames.begin(), kSolverNames.end(), name);
  if (found == kSolverNames.end()) {
    throw BadInput(fmt::format("'{}' is no solver: faithful, newton or fast", name));
  }
  return static_cast<RelocateSolver>(found - kSolverNames.begin());
}

std::string_view to_string(RelocateSolver solver) {
  return kSolverNames[static_cast<std::size_t>(solver)];
}

RelocateStart sample_relocate_start(RandomStream& random, double scale) {
  RelocateStart start;
  start.object.x() = 0.15 * scale - 0.1;
  start.object.y() = scale * random.uniform(-0.15, 0.15);
  start.target.x() = random.uniform(-0.3, 0.1);
  start.target.y() = random.uniform(-0.15, 0.15);
  start.target.z() = random.uniform(0.15, 0.25);
  return start;
}

RelocateModel::RelocateModel(const RelocateObject& object, const RelocatePhysics& physics) {
  auto impl = std::make_shared<Impl>();
  impl->scene = compose_relocate_scene(object, physics, RelocateVisuals::none);
  impl->start_height = object.start_height;
  for (int i = 0; i < kRelocateJoints; ++i) {
    const mjtNum* const range = impl->scene.model->actuator_ctrlrange + 2 * i;
    impl->center[i] = (range[0] + range[1]) / 2;
    impl->half_range[i] = (range[1] - range[0]) / 2;
  }
  impl_ = std::move(impl);
}

const RelocateAction& RelocateModel::action_center() const { return impl_->center; }
const RelocateAction& RelocateModel::action_half_range() const { return impl_->half_range; }
double RelocateModel::object_mass() const {
  return impl_->scene.model->body_mass[impl_->scene.object];
}

RelocateTask::Impl::Impl(const RelocateModel& m)
    : model(m), data(mj_makeData(m.impl().scene.model.get())) {
  if (!data) throw std::bad_alloc();
}

Eigen::Vector3d RelocateTask::Impl::palm() const {
  return simulation::vector3(data->site_xpos + 3 * scene().palm);
}

Eigen::Vector3d RelocateTask::Impl::object() const {
  return simulation::vector3(data->xpos + 3 * scene().object);
}

bool RelocateTask::Impl::contact() const {
  const auto& [hand, held] = std::tie(scene().hand, scene().held);
  return std::any_of(data->contact, data->contact + data->ncon, [&](const mjContact& c) {
    if (c.geom[0] < 0 || c.geom[1] < 0) return false;
    const auto a = static_cast<std::size_t>(c.geom[0]), b = static_cast<std::size_t>(c.geom[1]);
    return (held[a] && hand[b]) || (held[b] && hand[a]);
  });
}

int RelocateTask::Impl::touching_tips() const {
  const auto touches = [&](int tip) {
    return std::any_of(data->contact, data->contact + data->ncon, [&](const mjContact& c) {
      const int other = c.geom[0] == tip ? c.geom[1] : c.geom[0];
      return (c.geom[0] == tip || c.geom[1] == tip) && other >= 0 &&
             scene().held[static_cast<std::size_t>(other)] != 0;
    });
  };
  return static_cast<int>(std::ranges::count_if(scene().tips, touches));
}

RelocateJoints RelocateTask::Impl::noisy_joints() {
  RelocateJoints q = RelocateJoints::Map(data->qpos);
  for (double& value : q) value += start.encoder_noise * encoder_noise.normal();
  return q;
}

void RelocateTask::Impl::read_encoders() {
  if (start.encoder_noise == 0) return;
  const RelocateJoints now = noisy_joints();
  velocity += kVelocityFilter * ((now - read) / kControlStep - velocity);
  read = now;
}

RelocateTask::RelocateTask(const RelocateModel& model) : impl_(std::make_unique<Impl>(model)) {
  reset({});
}
RelocateTask::~RelocateTask() = default;
RelocateTask::RelocateTask(RelocateTask&&) noexcept = default;
RelocateTask& RelocateTask::operator=(RelocateTask&&) noexcept = default;

void RelocateTask::reset(const RelocateStart& start) {
  if (!start.object.allFinite() || !start.target.allFinite() || !start.object_bias.allFinite()) {
    throw BadInput(fmt::format(
        "an episode cannot start with the object at ({}, {}) and the target "
        "at ({}, {}, {})",
        start.object.x(), start.object.y(), start.target.x(), start.target.y(), start.target.z()));
  }
  const mjModel* const model = impl_->scene().model.get();
  mj_resetData(model, impl_->data.get());
  Eigen::Vector2d::Map(impl_->data->qpos + impl_->scene().object_joint) = start.object;
  impl_->start = start;
  mj_forward(model, impl_->data.get());
  impl_->encoder_noise = RandomStream(start.encoder_seed, "encoders");
  impl_->read = impl_->noisy_joints();
  impl_->velocity.setZero();
  impl_->seen.reset(impl_->object(), impl_->palm(), start.observation_period);
}

RelocateObservation RelocateTask::observation() const {
  RelocateObservation result;
  const Eigen::Vector3d palm = impl_->palm(), target = impl_->start.target;
  const Eigen::Vector3d object = impl_->seen.position() + impl_->start.object_bias;
  result << RelocateJoints::Map(impl_->data->qpos), palm - object, palm - target, object - target;
  return result;
}

Proprioception RelocateTask::proprioception() const {
  const bool exact = impl_->start.encoder_noise == 0;
  return {exact ? RelocateJoints(RelocateJoints::Map(impl_->data->qvel)) : impl_->velocity,
          RelocateJoints::Map(impl_->data->qfrc_bias)};
}

RelocateStep RelocateTask::step(const RelocateAction& action) {
  RelocateStep result;
  mjData& data = *impl_->data;
  if (action.allFinite()) {
    RelocateAction::Map(data.ctrl) =
        impl_->model.action_center() +
        action.cwiseMax(-1).cwiseMin(1).cwiseProduct(impl_->model.action_half_range());
    for (int i = 0; i < impl_->scene().substeps; ++i) mj_step(impl_->scene().model.get(), &data);
    impl_->read_encoders();
    impl_->seen.update(impl_->object(), impl_->palm(),
                       impl_->start.observation_period > 0 ? impl_->touching_tips() : 0);
  }
  const Eigen::Vector3d palm = impl_->palm(), object = impl_->object();
  const Eigen::Vector3d target = impl_->start.target;
  const Distances d = {(palm - object).norm(), (palm - target).norm(), (object - target).norm()};
  result.diverged = !action.allFinite() || broken(data) || !std::isfinite(d.object_target);
  if (result.diverged) return result;
  result.distance = d.object_target;
  result.contact = impl_->contact();
  const double height = std::min(object.z(), target.z());
  const double lift = std::max(height - impl_->model.impl().start_height, 0.0);
  result.reward = reward(d, result.contact, lift);
  return result;
}

Eigen::VectorXd RelocateTask::positions() const {
  return Eigen::VectorXd::Map(impl_->data->qpos, impl_->scene().model->nq);
}

const RelocateTask::Impl& RelocateTask::impl() const { return *impl_; }

}  // namespace palpate::relocate
