// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string_view>

#include "palpate/geometry/objects/known_object.hpp"
#include "palpate/hand/hand.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/hand/visuals.hpp"
#include "palpate/planning/fixture.hpp"
#include "palpate/simulation/contact/sensor_noise.hpp"
#include "palpate/simulation/hand/integral_action.hpp"
#include "palpate/simulation/hand/load_arm.hpp"
#include "palpate/simulation/world/object_step.hpp"
#include "palpate/simulation/world/world_errors.hpp"

namespace palpate::simulation {

struct WorldOptions {
  std::string hand = "shadow";   ///< a built-in or installed hand, or its MJCF, URDF or TOML
  double time_step = 0.002;      ///< s
  double hand_friction = 0.8;    ///< sliding, hand against object
  double table_friction = 0.5;   ///< sliding, object against table
  double stiffness_scale = 4.0;  ///< of the fingers' position controllers
  bool exact_tips = true;        ///< tips meet the true surface, the table its hull; else the parts
  bool biotacs = false;          ///< readings hold the channels of BioTacs on the fingertips
  bool second_object = false;    ///< a box that the robot does not know of stands beside the object
  double second_gap = 0.02;      ///< m between the two
  bool corrupted_truth = false;  ///< World::truth() is wrong: whoever acts on it shows
  simulation::IntegralOptions integral;
  SensorNoise noise;
  WorldErrors error;  ///< none unless asked for: see realistic()
  ArmOptions arm;     ///< visited where a world is the robot's own, not a forward model's

  /// A world like that of a real robot: nothing of it is exactly as given or as read.
  static WorldOptions realistic();

  template <class Visitor>
  void visit(Visitor&& v) {
    v("hand", hand, "a hand of `palpate hand list`, or a file that describes one");
    v.expert("time_step", time_step, 1e-4, 0.01, "s, time step of the physics");
    v("hand_friction", hand_friction, 0.0, 5.0, "friction coefficient of hand and object");
    v("table_friction", table_friction, 0.0, 5.0, "friction coefficient of table and object");
    v.expert("stiffness_scale", stiffness_scale, 0.1, 20.0,
             "factor on the stiffness of the fingers' position controllers");
    v.expert("exact_tips", exact_tips,
             "compute contacts of fingertips on the true surface instead of convex parts");
    v("biotacs", biotacs, "simulate the channels of BioTacs on the fingertips");
    v.expert("second_object", second_object,
             "a box that is unknown to the robot stands beside the object");
    v.expert("second_gap", second_gap, 0.0, 0.3, "m between the object and that box");
    v.expert("corrupted_truth", corrupted_truth,
             "report a corrupted true pose, which exposes code that uses it");
    v.expert_section("integral", integral);
    v.section("noise", noise);
    v.section("error", error);
  }
};

/// Where the object starts.
struct Start {
  int stable_pose = 0;                           ///< index into KnownObject::stable_poses
  double yaw = 0;                                ///< rad
  Eigen::Vector2d xy = Eigen::Vector2d::Zero();  ///< of the centroid, m
};

/// What only the simulator knows. For judging and drawing; never for estimating or acting.
struct Truth {
  Eigen::Isometry3d T_world_object = Eigen::Isometry3d::Identity();
  hand::JointVector joints;
  double lowest_point = 0;  ///< of the object's lowest vertex above the table, m
  Eigen::Isometry3d T_world_table = Eigen::Isometry3d::Identity();  ///< z = 0: its surface
};

/// A table, perhaps a fixture on it, a hand on its drive or arm and one free object, in MuJoCo.
class World {
 public:
  World(const geometry::KnownObject& object, const WorldOptions& options, std::uint64_t seed,
        const planning::Fixture& fixture = {});
  ~World();
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  /// Puts object and hand at their starts, at rest, at time 0.
  void reset(const Start& start, const hand::HandCommand& command);

  /// Where the object comes to rest from a start while the hand waits, m; none if it still moves
  /// after 10 s. Reset the world afterwards.
  std::optional<Eigen::Vector2d> resting_place(const Start& start,
                                               const hand::HandCommand& waiting);

  hand::Hand& hand();

  /// The hand as the estimator knows it: the physics follows the MJCF, and this model's links are
  /// off by SensorNoise::link. The same for every reset.
  const hand::Description& hand_model() const;
  Truth truth() const;

  /// Pushes the object along the table, whatever holds it, from now on.
  /// @param way  m, in the world
  void push_object(const Eigen::Vector2d& way, double seconds);

  /// Calls the observer after every step of the physics from now on; an empty one ends that.
  void observe(StepObserver observer);

  /// True when the simulation has become unstable since the last reset, or something in it is
  /// farther away than a recording holds (kMaxLength); readings then mean nothing.
  bool diverged() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Version of MuJoCo, as in "3.17.0".
std::string_view simulator_version();

}  // namespace palpate::simulation
