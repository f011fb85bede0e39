// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>

#include "common.hpp"
#include "given_command.hpp"
#include "hand_option.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/simulation/hand/hand_store.hpp"
#include "palpate/simulation/hand/load_hand.hpp"
#include "palpate/simulation/rendering/renderer.hpp"
#include "terminal.hpp"

namespace palpate::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* kHandHelp = "name of a hand, or an MJCF, URDF or TOML file";

struct CheckArguments {
  CommonOptions common;
  std::string hand;
  std::string render;
};

const std::string& joint_name(const hand::Description& hand, int joint) {
  return hand.joints[static_cast<std::size_t>(joint)].name;
}

/// Joints that an actuator of the finger moves, from the palm on.
std::vector<std::string> joints_of(const hand::Description& hand, int finger) {
  std::vector<std::string> names;
  for (const hand::Actuator& actuator : hand.actuators) {
    if (actuator.finger != finger) continue;
    for (const auto& driven : actuator.joints) names.push_back(joint_name(hand, driven.joint));
  }
  return names;
}

const std::string& tip_link(const hand::Description& hand, const hand::Finger& finger) {
  return hand.links[static_cast<std::size_t>(finger.link)].name;
}

/// A fingertip's surface in words.
std::string shape_of(const hand::Finger& finger) {
  if (!finger.hull) return fmt::format("capsule, radius {:.1f} mm", 1e3 * finger.tip.radius);
  return fmt::format("convex, {} corners", finger.hull->core.size());
}

nlohmann::json tip_json(const hand::Description& hand, const hand::Finger& finger) {
  nlohmann::json tip = {{"link", tip_link(hand, finger)},
                        {"shape", finger.hull ? "hull" : "capsule"},
                        {"radius", finger.tip.radius},
                        {"length", (finger.tip.b - finger.tip.a).norm()}};
  if (finger.hull) {
    tip["corners"] = finger.hull->core.size();
    tip["edge_radius"] = finger.hull->radius;
  }
  return tip;
}

nlohmann::json hand_json(const simulation::DescribedHand& loaded) {
  const hand::Description& hand = loaded.hand;
  auto fingers = nlohmann::json::array(), actuators = nlohmann::json::array();
  auto problems = nlohmann::json::array();
  for (int i = 0; i < hand.finger_count(); ++i) {
    const hand::Finger& finger = hand.fingers[static_cast<std::size_t>(i)];
    fingers.push_back({{"name", finger.name},
                       {"thumb", i == hand.thumb},
                       {"joints", joints_of(hand, i)},
                       {"tip", tip_json(hand, finger)}});
  }
  for (const hand::Actuator& actuator : hand.actuators) {
    actuators.push_back({{"name", actuator.name},
                         {"range", {actuator.command.low, actuator.command.high}},
                         {"stiffness", actuator.stiffness},
                         {"damping", actuator.damping},
                         {"max_torque", actuator.max_torque},
                         {"closing", actuator.closing}});
  }
  for (const auto& problem : loaded.problems) {
    problems.push_back({{"what", problem.what}, {"hint", problem.hint}});
  }
  return {{"hand", hand.name},    {"fingers", fingers},        {"actuators", actuators},
          {"problems", problems}, {"guesses", loaded.guesses}, {"joints", hand.joint_count()}};
}

void print_hand(const simulation::DescribedHand& loaded) {
  const hand::Description& hand = loaded.hand;
  fmt::print("{}: {} fingers, {} joints, {} actuators\n\n", hand.name, hand.finger_count(),
             hand.joint_count(), hand.actuator_count());
  std::size_t name_width = 10, tip_width = 18, actuator_width = 22;
  for (const hand::Finger& finger : hand.fingers) {
    name_width = std::max(name_width, finger.name.size());
    tip_width = std::max(tip_width, tip_link(hand, finger).size());
  }
  for (const hand::Actuator& actuator : hand.actuators) {
    actuator_width = std::max(actuator_width, actuator.name.size());
  }
  fmt::print("{:<{}} {:<{}} {:<23}  {}\n", "finger", name_width, "fingertip", tip_width, "surface",
             "joints");
  for (int i = 0; i < hand.finger_count(); ++i) {
    const hand::Finger& finger = hand.fingers[static_cast<std::size_t>(i)];
    fmt::print("{:<{}} {:<{}} {:<23}  {}{}\n", finger.name, name_width, tip_link(hand, finger),
               tip_width, shape_of(finger), fmt::join(joints_of(hand, i), " "),
               i == hand.thumb ? "  (thumb)" : "");
  }
  fmt::print("\n{:<{}} {:>15} {:>12} {:>10} {:>8}\n", "actuator", actuator_width, "range (rad)",
             "P (N m/rad)", "max (N m)", "closing");
  for (const hand::Actuator& actuator : hand.actuators) {
    fmt::print("{:<{}} {:>15} {:>12.2f} {:>10.2f} {:>8.2f}\n", actuator.name, actuator_width,
               fmt::format("{:.2f} .. {:.2f}", actuator.command.low, actuator.command.high),
               actuator.stiffness, actuator.max_torque, actuator.closing);
  }
  if (!loaded.guesses.empty()) fmt::print("\nGuessed:\n");
  for (const auto& guess : loaded.guesses) fmt::print("  {}\n", guess);
  if (!loaded.problems.empty()) fmt::print("\nProblems:\n");
  for (const auto& problem : loaded.problems) {
    fmt::print("  {}: {}\n", problem.what, problem.hint);
  }
  if (loaded.problems.empty()) fmt::print("\nNo problems.\n");
}

/// A name from a hand's file, in that of a picture: it must not name folders.
std::string in_file_name(std::string name) {
  std::ranges::replace(name, '/', '_');
  return name;
}

struct PosturePicture {
  std::string file;  ///< its name
  hand::ActuatorVector positions;
  hand::Attitude attitude;
};

std::vector<PosturePicture> posture_pictures(const hand::Description& hand) {
  const hand::Postures& postures = hand.postures;
  std::vector<PosturePicture> pictures = {
      {"open.png", postures.top.open, postures.top.attitudes.front()},
      {"closed.png", postures.top.closed, postures.top.attitudes.front()},
      {"flat.png", postures.flat.positions, postures.flat.attitude}};
  for (const auto& pointing : postures.pointing) {
    const auto& finger = hand.fingers[static_cast<std::size_t>(pointing.finger)];
    pictures.push_back(
        {in_file_name("pointing-" + finger.name) + ".png", pointing.positions, pointing.attitude});
  }
  return pictures;
}

void draw_postures(const hand::Description& hand, const fs::path& folder) {
  make_writable_folder(folder);
  const Notice notice("drawing postures", false);
  simulation::Renderer renderer(hand, geometry::load_known_object("box"), 640, 480);
  for (const PosturePicture& picture : posture_pictures(hand)) {
    simulation::DrawnState state;
    state.T_world_object.translation() << 0, 0, -1;
    state.joints = hand::joints_in_free_flexion(hand, picture.positions);
    state.mount.xyz.z() = 0.2;
    state.mount.ypr << 0, picture.attitude.pitch, picture.attitude.roll;
    simulation::Camera camera;
    camera.lookat.z() = 0.18;
    simulation::save_png(folder / picture.file, renderer.render(state, camera));
  }
}

int check(const CheckArguments& arguments) {
  const auto loaded = load_hand_with_progress(arguments.hand, arguments.common.quiet);
  if (!arguments.render.empty()) draw_postures(loaded.hand, arguments.render);
  if (arguments.common.json) {
    print_json(hand_json(loaded));
  } else {
    print_hand(loaded);
    if (!arguments.render.empty())
      fmt::print("\nThe postures are drawn in {}.\n", arguments.render);
    if (loaded.problems.empty()) {
      print_next(arguments.common, "palpate pick --object box --hand " + quoted(arguments.hand));
    }
  }
  return kDone;
}

int render(const CheckArguments& arguments) {
  const auto loaded = load_hand_with_progress(arguments.hand, arguments.common.quiet);
  std::vector<std::string> files, paths;
  for (const PosturePicture& picture : posture_pictures(loaded.hand)) {
    files.push_back(picture.file);
    paths.push_back((fs::path(arguments.common.out) / picture.file).string());
  }
  const auto output = claim_output(arguments.common, files);
  draw_postures(loaded.hand, arguments.common.out);
  if (arguments.common.json) {
    print_json(nlohmann::json{{"pictures", paths}});
  } else {
    for (const std::string& path : paths) fmt::print("{}\n", path);
    print_next(arguments.common, "palpate hand check " + quoted(arguments.hand));
  }
  return kDone;
}

nlohmann::json stored_json(const std::vector<simulation::StoredHand>& models) {
  auto result = nlohmann::json::array();
  for (const auto& model : models) {
    result.push_back({{"name", model.name},
                      {"model", model.maker},
                      {"licence", model.licence},
                      {"installed", !model.file.empty()},
                      {"path", model.file.string()}});
  }
  return result;
}

void print_stored(const char* kind, const std::vector<simulation::StoredHand>& models) {
  fmt::print("{:<14} {:<36} {:<14} {}\n", kind, "model", "licence", "file");
  for (const auto& model : models) {
    fmt::print("{:<14} {:<36} {:<14} {}\n", model.name, model.maker, model.licence,
               model.file.empty() ? "palpate hand install " + model.name : model.file.string());
  }
}

int list(const CommonOptions& common) {
  const auto hands = simulation::stored_hands(), arms = simulation::stored_arms();
  if (common.json) {
    const nlohmann::json report = {{"hands", stored_json(hands)}, {"arms", stored_json(arms)}};
    print_json(report);
    return kDone;
  }
  print_stored("hand", hands);
  fmt::print("\n");
  print_stored("arm", arms);
  return kDone;
}

int install(const CommonOptions& common, const std::string& name) {
  std::optional<Notice> notice(std::in_place, "fetching " + name, common.json);
  const fs::path file = simulation::install_hand(name);
  notice.reset();
  if (common.json) {
    print_json(nlohmann::json{{"path", file.string()}});
  } else {
    const auto arms = simulation::stored_arms();
    const bool arm = std::ranges::find(arms, name, &simulation::StoredHand::name) != arms.end();
    fmt::print("{}\nNext: {}\n", file.string(),
               arm ? fmt::format("palpate pick --arm {} --object box", name)
                   : fmt::format("palpate hand check {0} --render out/{0}", name));
  }
  return kDone;
}

void add_list(CLI::App& group, Command& chosen) {
  auto common = std::make_shared<CommonOptions>();
  auto& command = *group.add_subcommand("list", "List the hands and arms that are known by name");
  command.add_flag("--json", common->json, "print one JSON object");
  command.callback([common, &chosen] { chosen = [common] { return list(*common); }; });
}

void add_install(CLI::App& group, Command& chosen) {
  auto common = std::make_shared<CommonOptions>();
  auto name = std::make_shared<std::string>();
  auto& command = *group.add_subcommand(
      "install",
      "Fetch the model of a hand or arm of `palpate hand list` into the cache, with pip");
  command
      .add_option("NAME", *name,
                  "allegro, allegro-left, leap, leap-left, barrett, ur10, ur5 or panda")
      ->required();
  command.add_flag("--json", common->json, "print one JSON object");
  command.footer("Examples:\n  palpate hand install leap\n  palpate hand install ur10");
  command.callback(
      [common, name, &chosen] { chosen = [common, name] { return install(*common, *name); }; });
}

void add_check(CLI::App& group, Command& chosen) {
  auto arguments = std::make_shared<CheckArguments>();
  auto& command = *group.add_subcommand(
      "check", "Report what is derived from a hand's file, what is assumed, and what is wrong");
  command.add_option("HAND", arguments->hand, kHandHelp)->required();
  command.add_option("--render", arguments->render, "folder for a picture of each posture")
      ->option_text("DIR");
  command.add_flag("--json", arguments->common.json, "print one JSON object");
  command.footer(
      "Examples:\n"
      "  palpate hand check shadow\n"
      "  palpate hand check my_hand.xml --render out/my-hand\n"
      "  palpate pick --hand my_hand.xml --object box");
  command.callback([arguments, &chosen] { chosen = [arguments] { return check(*arguments); }; });
}

void add_postures_render(CLI::App& group, Command& chosen) {
  auto arguments = std::make_shared<CheckArguments>();
  auto& command = *group.add_subcommand(
      "render", "Draw the postures that are derived for a hand: open, closed, flat, pointing");
  command.add_option("HAND", arguments->hand, kHandHelp)->required();
  command.add_option("--out", arguments->common.out, "folder for the pictures")
      ->option_text("DIR")
      ->required();
  command.add_flag("--force", arguments->common.force, "overwrite the pictures that are in DIR");
  command.add_flag("--json", arguments->common.json, "print one JSON object");
  command.footer("Examples:\n  palpate hand render shadow --out out/shadow");
  command.callback([arguments, &chosen] { chosen = [arguments] { return render(*arguments); }; });
}

}  // namespace

void add_hand(CLI::App& program, Command& chosen) {
  auto& group = *program.add_subcommand("hand", "List, install, check and draw hand models");
  group.require_subcommand(1);
  group.footer(
      "Examples:\n"
      "  palpate hand list\n"
      "  palpate hand install leap\n"
      "  palpate hand check my_hand.xml --render out/my-hand");
  add_list(group, chosen);
  add_install(group, chosen);
  add_check(group, chosen);
  add_postures_render(group, chosen);
}

}  // namespace palpate::app
