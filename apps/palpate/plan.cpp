// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "common.hpp"
#include "given_command.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/core/se3.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/planning/execution.hpp"
#include "palpate/planning/planner.hpp"
#include "palpate/simulation/collision/collision_scene.hpp"
#include "palpate/simulation/hand/load_hand.hpp"
#include "palpate/simulation/world/world.hpp"
#include "plan_report.hpp"
#include "terminal.hpp"

namespace palpate::app {
namespace {

namespace pl = planning;
namespace si = simulation;

constexpr double kMountHeight = 0.3;  // m, where the file does not say: well above the table
// An estimate of an object that stands on the table is at most so far off.
constexpr double kOffTable = 0.01;                      // m
constexpr double kTilted = 5 * std::numbers::pi / 180;  // rad

struct PlanSettings {
  pl::PlanOptions plan;
  pl::CollisionOptions collision;
  si::WorldOptions world;
  pl::ExecutionOptions execution;

  template <class Visitor>
  void visit(Visitor&& v) {
    plan.visit(v);
    v.section("collision", collision);
    v.section("world", world);
    v.section("execution", execution);
  }
};

struct PlanArguments {
  CommonOptions common;
  std::string waypoints, object, pose, planner;
  bool held = false, execute = false;
};

struct Setting {
  hand::Description hand;
  std::vector<pl::Waypoint> waypoints;
  std::optional<geometry::KnownObject> object;
  Eigen::Isometry3d T_world_object = Eigen::Isometry3d::Identity();
  bool held = false;
};

Setting read_setting(const PlanArguments& arguments, const std::string& hand) {
  Setting setting;
  setting.hand = si::load_hand(hand);
  hand::MountPosition mount;
  mount.xyz.z() = kMountHeight;
  setting.waypoints =
      pl::parse_waypoints(read_file(arguments.waypoints), arguments.waypoints, mount, setting.hand)
          .waypoints;
  setting.held = arguments.held;
  if (arguments.object.empty()) return setting;
  setting.object = geometry::load_known_object(arguments.object);
  if (!arguments.pose.empty()) {
    setting.T_world_object = parse_pose(arguments.pose) * setting.object->T_mesh_object;
  } else {
    const geometry::StablePose& stable_pose = setting.object->stable_poses.front();
    setting.T_world_object.linear() = stable_pose.R_table_object;
    setting.T_world_object.translation().z() = stable_pose.height;
  }
  return setting;
}

si::CollisionScene make_scene(const Setting& setting, const pl::CollisionOptions& options) {
  if (!setting.object) return si::CollisionScene(setting.hand, options);
  si::CollisionScene scene(*setting.object, setting.hand, options);
  if (setting.held) {
    const hand::HandCommand start = pl::command_of(setting.waypoints.front(), setting.hand);
    const Eigen::Isometry3d T_world_palm =
        scene.palm_pose(start.mount, hand::joints_in_free_flexion(setting.hand, start.positions));
    scene.hold(T_world_palm.inverse() * setting.T_world_object);
  } else {
    scene.place(setting.T_world_object);
  }
  return scene;
}

/// The stable pose and yaw on the table that come nearest to the pose; none if it is not on it.
std::optional<si::Start> start_of(const geometry::KnownObject& object,
                                  const Eigen::Isometry3d& T_world_object) {
  si::Start start;
  double least = std::numbers::pi;
  for (std::size_t i = 0; i < object.stable_poses.size(); ++i) {
    const Eigen::Matrix3d turn =
        T_world_object.linear() * object.stable_poses[i].R_table_object.transpose();
    const double yaw = std::atan2(turn(1, 0) - turn(0, 1), turn(0, 0) + turn(1, 1));
    const Eigen::Matrix3d upright =
        Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    const double tilt = rotation_distance(turn, upright);
    if (tilt >= least) continue;
    least = tilt;
    start.stable_pose = static_cast<int>(i), start.yaw = yaw;
  }
  start.xy = T_world_object.translation().head<2>();
  const double height = object.stable_poses[static_cast<std::size_t>(start.stable_pose)].height;
  const double off = std::abs(T_world_object.translation().z() - height);
  if (least > kTilted || off > kOffTable) return std::nullopt;
  return start;
}

/// The simulated hand follows the samples; what is not placed on the table is out of its way.
pl::TrackingError follow(const Setting& setting, const std::vector<hand::HandCommand>& samples,
                         PlanSettings settings, std::uint64_t seed) {
  settings.world.noise.joint = 0;  // it is the controllers that are judged, not the readers
  const auto object = setting.object ? *setting.object : geometry::load_known_object("box");
  std::optional<si::Start> start;
  if (setting.object && !setting.held) start = start_of(object, setting.T_world_object);
  if (!start) start.emplace().xy.setConstant(10);
  si::World world(object, settings.world, seed);
  world.reset(*start, samples.front());
  return pl::execute(world.hand(), world.hand_model(), samples, settings.execution);
}

void write_results(const PlanArguments& arguments, const PlanSettings& settings,
                   const hand::Description& hand, const pl::Plan& plan,
                   const std::optional<pl::TrackingError>& tracking) {
  const std::filesystem::path folder = arguments.common.out;
  const auto output =
      claim_output(arguments.common, {"report.json", "config.toml", "path.csv", "path.svg"});
  write_file_atomically(folder / "report.json", json_text(plan_report(plan, tracking)));
  write_file_atomically(folder / "config.toml",
                        config_header(arguments.common) + to_toml(settings));
  if (plan.samples.empty()) return;
  write_file_atomically(folder / "path.csv", path_csv(plan.samples, hand));
  write_file_atomically(folder / "path.svg", plot_motion(plan, tracking, hand));
}

void print_result(const pl::Plan& plan, const std::optional<pl::TrackingError>& tracking) {
  if (plan.status == pl::PlanStatus::no_path) {
    fmt::print("{} to waypoint {} ({} configurations checked in {:.0f} ms)\n",
               colored_status("no path"), plan.unreachable, plan.checks, 1e3 * plan.seconds);
    return;
  }
  fmt::print("{} waypoints, {} corners, {:.2f} s of motion; planned in {:.0f} ms ({} checks)\n",
             plan.arrivals.size(), plan.corners.size(), plan.duration(), 1e3 * plan.seconds,
             plan.checks);
  if (!tracking) return;
  fmt::print("tracking error, rms (max): joints {:.2f} ({:.2f}) deg, mount {:.2f} ({:.2f}) mm\n",
             tracking->joint_rms * 180 / std::numbers::pi,
             tracking->joint_max * 180 / std::numbers::pi, 1e3 * tracking->mount_rms,
             1e3 * tracking->mount_max);
}

void check(const PlanArguments& arguments) {
  if (!arguments.object.empty()) return;
  if (arguments.held) throw BadInput("--held needs --object: there is nothing to hold");
  if (!arguments.pose.empty()) throw BadInput("--pose needs --object: whose pose is it?");
}

/// Where the motion is seen.
void print_next_of(const PlanArguments& arguments, const CLI::App& command) {
  const std::string& out = arguments.common.out;
  if (!out.empty()) {
    print_next(arguments.common, fmt::format("open {}/path.svg in a browser", out));
  } else if (arguments.execute) {
    print_next(arguments.common,
               given_command(command) + " --out out/plan writes the motion and draws it");
  } else {
    print_next(arguments.common,
               given_command(command) + " --execute lets the simulated hand follow it");
  }
}

int plan(const PlanArguments& arguments, const CLI::App& command) {
  check(arguments);
  auto settings = resolve<PlanSettings>(arguments.common);
  if (!arguments.planner.empty()) settings.plan.planner = arguments.planner;
  const Setting setting = read_setting(arguments, settings.world.hand);
  std::optional<Notice> notice(std::in_place, "planning", arguments.common.quiet);
  si::CollisionScene scene = make_scene(setting, settings.collision);
  const pl::Plan result = pl::plan(setting.waypoints, scene, settings.plan, arguments.common.seed);
  const bool ok = result.status == pl::PlanStatus::ok;
  std::optional<pl::TrackingError> tracking;
  if (arguments.execute && ok) {
    tracking = follow(setting, result.samples, settings, arguments.common.seed);
  }
  notice.reset();
  if (result.status != pl::PlanStatus::invalid && !arguments.common.out.empty()) {
    write_results(arguments, settings, setting.hand, result, tracking);
  }
  if (arguments.common.json) print_json(plan_report(result, tracking));
  if (result.status == pl::PlanStatus::invalid) throw BadInput(describe_invalid(result.invalid));
  if (!arguments.common.json) print_result(result, tracking);
  if (ok) print_next_of(arguments, command);
  return ok ? kDone : kNoSolution;
}

}  // namespace

std::vector<OptionInfo> plan_option_list() { return list_options(PlanSettings{}); }

void add_plan(CLI::App& program, Command& chosen) {
  auto arguments = std::make_shared<PlanArguments>();
  auto& command = *program.add_subcommand(
      "plan", "Plan a collision-free motion of mount and hand through waypoints");
  command
      .add_option("waypoints", arguments->waypoints,
                  "CSV with all joints of the hand (rad; the Shadow hand has 24) by name and, "
                  "optionally, the mount's x,y,z,yaw,pitch,roll (m, rad)")
      ->option_text("WAYPOINTS")
      ->required();
  command
      .add_option("--object", arguments->object,
                  "built-in object or mesh file in metres, as an obstacle; without --pose it "
                  "stands at the origin")
      ->option_text("O");
  command
      .add_option(
          "--pose", arguments->pose,
          "pose of the object's mesh in the world: 16 numbers, row-major, or a file of them")
      ->option_text("POSE");
  command.add_flag("--held", arguments->held,
                   "the hand holds the object, which is at its pose at the first waypoint");
  command
      .add_option("--planner", arguments->planner, "rrt-connect (default), rrt-star, prm or fmt")
      ->check(CLI::IsMember({"rrt-connect", "rrt-star", "prm", "fmt"}));
  command.add_flag("--execute", arguments->execute,
                   "let the simulated hand follow the motion, and report its tracking error");
  add_common_options(command, arguments->common, kConfig | kSeed | kOut);
  command.footer(
      "The motion is at rest in every waypoint. Limits of speed, acceleration and reach, the "
      "depth\n"
      "of contact that is allowed and the bounds of the search are options (--set, --config).\n"
      "J1 and J2 of a finger of the Shadow hand share one tendon as on the real hand, so that\n"
      "J1 + J2 is met, not each; J1 may not exceed J2. --set world.hand=NAME plans for another\n"
      "hand. Without a pose of the mount in the file it rests at z = 0.3 m.\n"
      "--out receives path.csv (100 samples per second), path.svg, report.json, config.toml.\n"
      "Exits with 3 for a waypoint beyond limits or in collision (named), 4 if there is no "
      "path.\n\n"
      "Examples:\n"
      "  palpate plan examples/waypoints.csv --execute\n"
      "  palpate plan examples/waypoints.csv --object box --planner rrt-star --json\n"
      "  palpate plan reach.csv --object mug --pose pose.txt --held --out out/transport\n"
      "  palpate plan reach.csv --set limits.mount_speed=0.1 --set collision.allowed_depth=0.002");
  command.callback([arguments, &command, &chosen] {
    chosen = [arguments, &command] { return plan(*arguments, command); };
  });
}

}  // namespace palpate::app
