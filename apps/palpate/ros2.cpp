// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "common.hpp"
#include "hand_option.hpp"
#include "interface_option.hpp"
#include "interrupt.hpp"
#include "palpate/bridge/estimator_node.hpp"
#include "palpate/bridge/hand_peer.hpp"
#include "palpate/evaluation/trial.hpp"
#include "palpate/simulation/collision/forward_model.hpp"

namespace palpate::app {
namespace {

struct Ros2Arguments {
  CommonOptions common;
  std::string object = "mug", hand;
  std::optional<int> domain;
  ros2::RobotInterface interface;
  bool real_time = false, perturb_links = false;
  double timeout = bridge::RemoteHandOptions{}.timeout;
  bridge::CommandTopics commands;
  bool positions = false;
};

int domain_of(const Ros2Arguments& arguments) {
  return arguments.domain ? *arguments.domain : bridge::default_domain();
}

void say_ready(const Ros2Arguments& arguments, std::string_view what) {
  if (arguments.common.quiet) return;
  fmt::print(stderr, "{} in domain {}; Ctrl-C ends\n", what, domain_of(arguments));
}

/// What all of them report.
nlohmann::json report_of(std::uint64_t messages) {
  return {{"path", nullptr}, {"messages", messages}};
}

/// Says once, to who waits in vain, of what topics nothing can come.
class SenderNotice {
 public:
  explicit SenderNotice(bool quiet) : said_(quiet) {}
  void say(const std::string& refused) {
    if (said_ || refused.empty()) return;
    fmt::print(stderr, "senders of {} are best effort, and not heard: --best-effort takes them\n",
               refused);
    said_ = true;
  }

 private:
  bool said_;
};

nlohmann::json counts_json(const ros2::StreamCounts& counts) {
  return {{"joint_states", counts.joint_states},
          {"contacts", counts.contacts},
          {"transforms", counts.transforms},
          {"readings", counts.readings},
          {"malformed", counts.malformed},
          {"out_of_order", counts.out_of_order},
          {"gaps", counts.gaps},
          {"incomplete", counts.incomplete},
          {"restarts", counts.restarts},
          {"last_error", counts.last_error}};
}

void print_report(const Ros2Arguments& arguments, const nlohmann::json& report) {
  if (arguments.common.json) {
    print_json(report);
    return;
  }
  for (const auto& [key, value] : report.items()) fmt::print("{}: {}", key, json_text(value, -1));
}

int estimate(const Ros2Arguments& arguments) {
  const auto options = resolve<estimation::HeldPoseOptions>(arguments.common);
  const auto hand = load_hand_with_progress(arguments.hand, arguments.common.quiet).hand;
  const geometry::ObjectModel object(geometry::load_known_object(arguments.object));
  const Interrupt interrupt;
  bridge::Participant participant(domain_of(arguments));
  bridge::EstimatorNode node(participant, object, hand, arguments.interface, options,
                             arguments.common.seed);
  say_ready(arguments, fmt::format("estimating the pose of {} in {}", arguments.object, hand.name));
  SenderNotice notice(arguments.common.quiet);
  node.run(interrupt.token(), [&](const bridge::NodeReport& now) { notice.say(now.refused); });
  const bridge::NodeReport node_report = node.report();
  auto report = report_of(node_report.messages);
  report.update({{"received", counts_json(node_report.received)},
                 {"lost", node_report.lost},
                 {"refused", node_report.refused},
                 {"poses", node_report.poses},
                 {"estimates", node_report.estimates},
                 {"failed_estimates", node_report.failed},
                 {"last_failure", node_report.last_failure},
                 {"commands", node_report.commands}});
  print_report(arguments, report);
  return kDone;
}

int serve_robot(const Ros2Arguments& arguments) {
  const auto options = resolve_trial(arguments.common, arguments.hand);
  const geometry::ObjectModel object(geometry::load_known_object(arguments.object));
  simulation::World world(object.object(), options.world, arguments.common.seed);
  evaluation::start_trial(world, object.object(), options.start, arguments.common.seed);
  const auto waiting = evaluation::waiting_command(world.hand_model());
  const double height = world.truth().T_world_object.translation().z();
  const Interrupt interrupt;
  bridge::Participant participant(domain_of(arguments));
  bridge::HandServer server(participant, world.hand(), world.hand_model(), arguments.interface,
                            arguments.commands, {.real_time = arguments.real_time});
  say_ready(arguments,
            fmt::format("simulating {} with {}", world.hand_model().name, arguments.object));
  server.run(waiting, interrupt.token());
  auto report = report_of(server.messages());
  report.update({{"ticks", server.ticks()},
                 {"malformed", server.malformed()},
                 {"risen", world.truth().T_world_object.translation().z() - height},
                 {"T_world_object", to_json(world.truth().T_world_object)}});
  print_report(arguments, report);
  return kDone;
}

/// The hand as it is believed to be.
hand::Description believed_hand(const Ros2Arguments& arguments,
                                const evaluation::TrialOptions& options,
                                const geometry::ObjectModel& object) {
  if (!arguments.perturb_links) {
    return load_hand_with_progress(options.world.hand, arguments.common.quiet).hand;
  }
  return simulation::World(object.object(), options.world, arguments.common.seed).hand_model();
}

nlohmann::json pick_json(const skills::PickResult& picked, const skills::Executor& robot) {
  const auto& posterior = picked.estimate.posterior;
  auto modes = nlohmann::json::array();
  for (const auto& mode : posterior.modes) {
    modes.push_back({{"T_world_object", to_json(mode.T_frame_object)}, {"weight", mode.weight}});
  }
  auto faults = nlohmann::json::array();
  const auto add = [&](const skills::FaultReport& fault, bool stopped) {
    faults.push_back({{"name", to_string(fault.fault)},
                      {"detail", fault.detail},
                      {"time", fault.time},
                      {"stopped", stopped}});
  };
  for (const skills::FaultReport& fault : picked.survived) add(fault, false);
  if (picked.fault) add(picked.fault, true);
  return {{"status", picked.fault  ? "fault"
                     : picked.held ? "ok"
                                   : "failed"},
          {"faults", faults},
          {"failed_phase", picked.failed_phase},
          {"attempts", picked.attempts},
          {"robot_seconds", robot.time()},
          {"estimate",
           {{"status", localization::to_string(posterior.status)},
            {"probability", localization::best_probability(posterior)},
            {"modes", modes}}}};
}

int pick(const Ros2Arguments& arguments) {
  const auto options = resolve_trial(arguments.common, arguments.hand);
  const geometry::ObjectModel object(geometry::load_known_object(arguments.object));
  const auto hand = believed_hand(arguments, options, object);
  const Interrupt interrupt;
  bridge::Participant participant(domain_of(arguments));
  bridge::RemoteHand remote(participant, hand, arguments.interface, arguments.commands,
                            {.timeout = arguments.timeout, .positions = arguments.positions});
  say_ready(arguments, fmt::format("picking {} with {}", arguments.object, hand.name));
  const simulation::SimulatedModels models(options.forward_model_options());
  skills::Executor robot(remote, hand, evaluation::waiting_command(hand), {}, &models,
                         {options.safety, interrupt.token()});
  const auto picked = skills::pick(robot, object, options.pick_options(), arguments.common.seed);
  auto report = report_of(remote.messages());
  report.update(pick_json(picked, robot));
  report.update({{"received", counts_json(remote.counts())}, {"repeats", remote.repeats()}});
  print_report(arguments, report);
  if (picked.fault) return kStopped;
  return picked.held ? kDone : kNoSolution;
}

void add_command_topics(CLI::App& command, bridge::CommandTopics& topics) {
  command.add_option("--trajectories", topics.joints, "topic of the joints' JointTrajectory")
      ->option_text("TOPIC")
      ->capture_default_str();
  command.add_option("--positions", topics.positions, "topic of the joints' Float64MultiArray")
      ->option_text("TOPIC")
      ->capture_default_str();
  command.add_option("--mount-target", topics.mount, "topic of the mount's PoseStamped")
      ->option_text("TOPIC")
      ->capture_default_str();
}

using Job = int (*)(const Ros2Arguments&);

CLI::App& add_job(CLI::App& ros2, Command& chosen, const std::shared_ptr<Ros2Arguments>& arguments,
                  const std::string& name, const std::string& help, Job job) {
  auto& command = *ros2.add_subcommand(name, help);
  command.add_option("--object", arguments->object, "built-in object or mesh file in metres")
      ->option_text("O")
      ->capture_default_str();
  add_hand_option(command, arguments->hand);
  command.add_option("--domain", arguments->domain, "DDS domain (default: ROS_DOMAIN_ID, or 0)")
      ->option_text("N")
      ->check(in_range(0, 232));
  add_interface_options(command, arguments->interface);
  if (name != "estimate") add_command_topics(command, arguments->commands);
  add_common_options(command, arguments->common, kConfig | kSeed);
  command.callback(
      [arguments, job, &chosen] { chosen = [arguments, job] { return job(*arguments); }; });
  return command;
}

}  // namespace

std::vector<OptionInfo> ros2_estimate_option_list() {
  return list_options(estimation::HeldPoseOptions{});
}

void add_ros2(CLI::App& program, Command& chosen) {
  auto& ros2 = *program.add_subcommand(
      "ros2", "Exchange messages with ROS 2 nodes, without an installation of ROS (docs/ros2.md)");
  ros2.require_subcommand(1);
  auto arguments = std::make_shared<Ros2Arguments>();
  auto& estimator =
      add_job(ros2, chosen, arguments, "estimate",
              "Estimate the pose of the object in a hand that another program controls", &estimate);
  add_best_effort_option(estimator, arguments->interface);
  estimator.footer(
      "Subscribes to /joint_states, /contacts/FINGER and /tf, and publishes /palpate/estimate,\n"
      "modes, status, markers and /tf until interrupted; /palpate/command takes start, stop and\n"
      "estimate.\n\n"
      "Examples:\n"
      "  palpate ros2 estimate --object mug --hand shadow\n"
      "  palpate ros2 estimate --object part.stl --hand my_hand.xml --mount-frame wrist_3_link");
  auto& robot = add_job(ros2, chosen, arguments, "robot",
                        "Run a simulated hand and object behind ROS 2 topics", &serve_robot);
  robot.add_flag("--real-time", arguments->real_time,
                 "run in real time (10 ms per tick); otherwise one tick per command");
  robot.footer(
      "Examples:\n"
      "  palpate ros2 robot --object mug --hand shadow --seed 3 --real-time");
  auto& picker =
      add_job(ros2, chosen, arguments, "pick", "Pick with a hand behind ROS 2 topics", &pick);
  add_best_effort_option(picker, arguments->interface);
  picker.add_option("--timeout", arguments->timeout, "time that a tick waits for its reading, s")
      ->option_text("S")
      ->check(in_range(0.01, 60.0))
      ->capture_default_str();
  picker.add_flag("--by-positions", arguments->positions,
                  "command the joints by Float64MultiArray, all actuators in their order, instead "
                  "of by JointTrajectory");
  picker.add_flag(
      "--perturb-links", arguments->perturb_links,
      "for a simulated hand: perturb the assumed links by world.noise.link, as pick does");
  picker.footer(
      "Examples:\n"
      "  palpate ros2 pick --object mug --hand shadow --seed 3   # beside palpate ros2 robot\n"
      "  palpate ros2 pick --object mug --by-positions --positions /forward_controller/commands");
  ros2.footer(
      "Examples:\n"
      "  palpate ros2 estimate --object mug --hand shadow\n"
      "  palpate ros2 robot --object mug --real-time\n"
      "  palpate ros2 pick --object mug");
}

}  // namespace palpate::app
