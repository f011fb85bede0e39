// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/reorient/in_hand_reorientation.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <span>

#include "palpate/core/error.hpp"
#include "palpate/core/gravity.hpp"
#include "palpate/estimation/mean_load.hpp"
#include "palpate/grasping/force_distribution.hpp"
#include "skills/grasp/pressing.hpp"
#include "skills/reorient/step_sampler.hpp"

namespace palpate::skills {
namespace {

constexpr std::array<std::string_view, 4> kEndNames = {"reached", "out_of_time", "drift", "losing"};

double largest_deviation(const Eigen::Matrix3d& covariance) {
  return std::sqrt(
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance).eigenvalues().maxCoeff());
}

Vector6d shortened(const Vector6d& way, double angle, double length) {
  const double longest = std::max(way.head<3>().norm() / angle, way.tail<3>().norm() / length);
  return longest > 1 ? Vector6d(way / longest) : way;
}

/// Sum of the normal forces, N.
double pressing_force(std::span<const tactile::Contact> contacts) {
  double sum = 0;
  for (const auto& contact : contacts) sum -= contact.f.dot(contact.n);
  return sum;
}

/// The goal is one for the best mode: another one would have another.
localization::Posterior heaviest(localization::Posterior posterior) {
  if (posterior.modes.empty()) throw BadInput("a reorientation needs a pose of the held object");
  posterior.modes.resize(1);
  posterior.modes.front().weight = 1;
  return posterior;
}

/// Steps, looks and keeps track for one reorientation.
class Reorientation {
 public:
  Reorientation(Executor& robot, const geometry::ObjectModel& object,
                const localization::Posterior& held, const Eigen::Isometry3d& T_world_goal,
                const ReorientOptions& options, RandomStream random)
      : robot_(robot),
        options_(options),
        goal_(T_world_goal),
        weight_(object.object().mass * kGravity),
        random_(random),
        tracker_(object, heaviest(held), options.tracker, random.fork("tracker")) {}

  ReorientResult run(StepSampler& sampler) {
    ReorientResult result;
    const double begin = robot_.time();
    bool late = !rest();
    auto end = look();
    while (!end) {
      if (late || robot_.time() - begin > options_.longest) {
        end = ReorientEnd::out_of_time;
        break;
      }
      const auto started = std::chrono::steady_clock::now();
      const auto chosen =
          sampler.choose(view_, next_step(result.steps),
                         random_.fork("step", static_cast<std::uint64_t>(result.steps)));
      result.plan_seconds +=
          std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
      ++result.steps;
      if (chosen.falls) {
        end = ReorientEnd::losing;
        break;
      }
      late = robot_.move_fingers(targets_of(robot_, view_, chosen.motion), options_.period) ==
             MotionEnd::timed_out;
      late = !rest() || late;
      displacement_ = chosen.displacement;
      end = look();
    }
    result.end = *end;
    result.posterior = tracker_.posterior();
    result.left = left();
    result.slips = tracker_.slips();
    result.seconds = robot_.time() - begin;
    return result;
  }

 private:
  /// @return whether there was time for it
  bool rest() { return robot_.wait(options_.pause) != MotionEnd::timed_out; }

  const Eigen::Isometry3d& tracked() const {
    return tracker_.posterior().modes.front().T_frame_object;
  }

  localization::PoseError left() const {
    return localization::pose_error(tracked(), goal_, {Eigen::Matrix3d::Identity()});
  }

  Vector6d next_step(int steps) const {
    if (steps < options_.tightenings) return Vector6d::Zero();
    const Eigen::Isometry3d T_mount_world = robot_.command().mount.pose().inverse();
    return shortened(way_between(T_mount_world * tracked(), T_mount_world * goal_),
                     options_.speed * options_.period, options_.linear_speed * options_.period);
  }

  /// Remembers where the fingertips touch, for those that will not in the next look: they go along
  /// with the object and are pressed against it for a while.
  void remember_contacts() {
    const auto T_mount_link = hand::forward_kinematics(robot_.model(), view_.joints);
    hand::PerFinger<bool> touches{};
    for (const auto& contact : view_.contacts) {
      const auto finger = static_cast<std::size_t>(contact.finger);
      const auto link = static_cast<std::size_t>(robot_.model().fingers[finger].link);
      touches[finger] = true;
      lasts_[finger] = contact;
      lasts_[finger]->p = T_mount_link[link].inverse() * contact.p;
      lasts_[finger]->n = T_mount_link[link].linear().transpose() * contact.n;
      missed_[finger] = 0;
    }
    view_.lost.clear();
    view_.regain = options_.regain;
    for (std::size_t finger = 0; finger < robot_.model().fingers.size(); ++finger) {
      if (touches[finger] || !lasts_[finger] || ++missed_[finger] > options_.regains) continue;
      const auto link = static_cast<std::size_t>(robot_.model().fingers[finger].link);
      tactile::Contact contact = *lasts_[finger];
      contact.p = T_mount_link[link] * contact.p;
      contact.n = T_mount_link[link].linear() * contact.n;
      view_.lost.push_back(contact);
    }
  }

  /// By how much the commands must lead so that the fingertips press with forces that bear the
  /// weight, wherever the contacts have gone.
  hand::ActuatorVector correcting_lead(double gain) const {
    hand::ActuatorVector lead = hand::ActuatorVector::Zero(robot_.model().actuator_count());
    const auto balanced =
        grasping::distribute_forces(view_.contacts, options_.friction, options_.grip * first_force_,
                                    weight_at(robot_, tracked(), weight_));
    const auto torques =
        grasping::pressing_torques(robot_.model(), view_.joints, view_.contacts, balanced.forces);
    const hand::ActuatorVector sensed = contact_torques(robot_);
    for (Eigen::Index i = 0; i < lead.size(); ++i) {
      if (torques[i] == 0) continue;
      lead[i] = gain * (torques[i] - sensed[i]) /
                robot_.actuators()[static_cast<std::size_t>(i)].stiffness;
    }
    return lead;
  }

  /// Reads where the fingertips are and lets the tracker follow.
  std::optional<ReorientEnd> look() {
    const auto& readings = robot_.log().readings;
    const auto count = static_cast<std::size_t>(std::lround(options_.pause / hand::kTick));
    const auto window =
        std::span(readings).last(std::min(std::max<std::size_t>(count, 1), readings.size()));
    hand::JointVector joints = hand::JointVector::Zero(robot_.model().joint_count());
    for (const auto& reading : window) {
      joints += reading.joints / static_cast<double>(window.size());
    }
    view_.command = robot_.command();
    view_.joints = joints;
    view_.contacts = tactile::contacts_with_normals(
        tactile::lasting_contacts(window, robot_.model(), options_.errors));
    remember_contacts();
    if (first_force_ == 0) first_force_ = pressing_force(view_.contacts);
    view_.lead = correcting_lead(looks_++ < options_.tightenings ? options_.tighten_gain
                                                                 : options_.force_gain);
    tracker_.update(frame());
    view_.T_mount_object = robot_.reading().mount.pose().inverse() * tracked();
    return ending();
  }

  /// Contacts in the world, and how fast the object has moved there since the last look: as it did
  /// in the rollout, or else with fingertips that stick.
  localization::TrackFrame frame() {
    const auto T_mount_link = hand::forward_kinematics(robot_.model(), view_.joints);
    const Eigen::Isometry3d T_world_mount = robot_.reading().mount.pose();
    const double time = robot_.time();
    localization::TrackFrame frame;
    frame.time = time;
    for (tactile::Contact contact : view_.contacts) {
      const auto link = static_cast<std::size_t>(
          robot_.model().fingers[static_cast<std::size_t>(contact.finger)].link);
      Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
      if (!last_links_.empty()) {
        const Eigen::Vector3d before =
            displacement_ ? displacement_->inverse() * contact.p
                          : last_links_[link] * T_mount_link[link].inverse() * contact.p;
        velocity = T_world_mount.linear() * (contact.p - before) / (time - last_time_);
      }
      contact.p = T_world_mount * contact.p;
      contact.n = T_world_mount.linear() * contact.n;
      contact.f = T_world_mount.linear() * contact.f;
      frame.contacts.push_back(contact);
      frame.velocities.push_back(velocity);
    }
    last_links_ = T_mount_link;
    last_time_ = time;
    return frame;
  }

  std::optional<ReorientEnd> ending() {
    hand::PerFinger<bool> touches{};
    for (const auto& contact : view_.contacts) {
      touches[static_cast<std::size_t>(contact.finger)] = true;
    }
    if (std::count(touches.begin(), touches.end(), true) < options_.min_fingers) {
      return ReorientEnd::losing;
    }
    if (!well_known(tracker_.posterior().modes.front(), options_)) return ReorientEnd::drift;
    const auto error = left();
    const double distance =
        std::max(error.rotation / options_.done_angle, error.translation / options_.done_distance);
    if (distance < 1) return ReorientEnd::reached;
    stalled_ = distance < nearest_ ? 0 : stalled_ + 1;
    nearest_ = std::min(nearest_, distance);
    if (stalled_ > options_.patience) return ReorientEnd::out_of_time;
    return std::nullopt;
  }

  Executor& robot_;
  const ReorientOptions& options_;
  Eigen::Isometry3d goal_;
  double weight_;  // of the object, N
  RandomStream random_;
  localization::Tracker tracker_;
  GraspView view_;
  int looks_ = 0;
  double nearest_ = std::numeric_limits<double>::infinity();  // to the goal, in what is enough
  int stalled_ = 0;                                           // looks since then
  hand::PerFinger<std::optional<tactile::Contact>> lasts_;    // link's frame
  hand::PerFinger<int> missed_{};                             // looks without touch
  double first_force_ = 0;                                    // N, of all fingertips
  std::optional<Eigen::Isometry3d> displacement_;  // that the last step was rolled out to make
  std::vector<Eigen::Isometry3d> last_links_;
  double last_time_ = 0;
};

}  // namespace

bool well_known(const localization::Mode& mode, const ReorientOptions& options) {
  return largest_deviation(mode.covariance.topLeftCorner<3, 3>()) <= options.drift_angle &&
         largest_deviation(mode.covariance.bottomRightCorner<3, 3>()) <= options.drift_distance;
}

std::string_view to_string(ReorientEnd end) { return kEndNames[static_cast<std::size_t>(end)]; }

ReorientResult reorient_in_hand(Executor& robot, const geometry::ObjectModel& object,
                                const localization::Posterior& held,
                                const Eigen::Isometry3d& T_world_goal,
                                const ReorientOptions& options, std::uint64_t seed, int threads) {
  if (!T_world_goal.matrix().allFinite()) {
    throw BadInput("the goal of a reorientation has a value that is not finite");
  }
  Reorientation reorientation(robot, object, held, T_world_goal, options,
                              RandomStream(seed, "reorient"));
  StepSampler sampler(object.object(), robot, options, threads);
  ReorientResult result = reorientation.run(sampler);
  result.rollouts = sampler.rollouts();
  return result;
}

}  // namespace palpate::skills
