// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "common.hpp"
#include "given_command.hpp"
#include "hand_option.hpp"
#include "hand_report.hpp"
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

constexpr const char* kCorrect =
    "If the thumb, the closing joints, the root or the mount above are wrong, a TOML file corrects "
    "them (docs/hands.md; keys: palpate options hand check)";
constexpr const char* kHandHelp = "name of a hand, or an MJCF, URDF or TOML file";

struct CheckArguments {
  CommonOptions common;
  std::string hand;
  std::string render;
};

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

/// The fingers straight, and half closed by the joints that are to close them: of a hand for which
/// no postures were found.
std::vector<PosturePicture> closing_pictures(const hand::Description& hand) {
  std::vector<PosturePicture> pictures;
  for (const double share : {0.0, 0.5}) {
    pictures.push_back({share == 0 ? "straight.png" : "half-closed.png",
                        simulation::partly_closed(hand, share),
                        {}});
  }
  return pictures;
}

std::vector<PosturePicture> posture_pictures(const hand::Description& hand) {
  const hand::Postures& postures = hand.postures;
  if (postures.top.attitudes.empty()) return closing_pictures(hand);
  std::vector<PosturePicture> pictures = {
      {"open.png", postures.top.open, postures.top.attitudes.front()},
      {"closed.png", postures.top.closed, postures.top.attitudes.front()},
      {"flat.png", postures.flat.positions, postures.flat.attitude}};
  for (const auto& pointing : postures.pointing) {
    const auto& finger = hand.fingers[static_cast<std::size_t>(pointing.finger)];
    std::string name = in_file_name("pointing-" + finger.name);
    while (std::ranges::count(pictures, name + ".png", &PosturePicture::file) > 0) name += '_';
    pictures.push_back({name + ".png", pointing.positions, pointing.attitude});
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
  const auto loaded = describe_hand_with_progress(arguments.hand, arguments.common.quiet);
  if (!arguments.render.empty()) draw_postures(loaded.hand, arguments.render);
  if (arguments.common.json) {
    print_json(hand_json(loaded));
  } else {
    print_hand(loaded);
    if (!arguments.render.empty())
      fmt::print("\nThe postures are drawn in {}.\n", arguments.render);
    if (loaded.problems.empty() && loaded.failure.empty()) {
      print_next(arguments.common, "palpate pick --object box --hand " + quoted(arguments.hand));
    }
  }
  if (!loaded.failure.empty()) throw BadInput(loaded.failure + ". " + kCorrect);
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
