// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <optional>
#include <vector>

#include "common.hpp"
#include "given_command.hpp"
#include "palpate/core/error.hpp"
#include "palpate/hand/tip_forces.hpp"
#include "palpate/ros2/export_recording.hpp"
#include "palpate/ros2/read_bag.hpp"
#include "palpate/tasks/relocate/episode_recording.hpp"
#include "terminal.hpp"

namespace palpate::app {
namespace {

namespace fs = std::filesystem;

struct ExportArguments {
  std::string format, recording, out;
  bool force = false, json = false;
};

/// Whether a path is that of the recording, or of a folder around it.
bool holds_recording(const fs::path& path, const fs::path& recording) {
  std::error_code error;
  for (fs::path at = fs::canonical(recording, error); at.has_relative_path();
       at = at.parent_path()) {
    if (fs::equivalent(at, path, error)) return true;
  }
  return false;
}

/// Where it is written, unless that would replace the recording.
fs::path path_of(const ExportArguments& arguments) {
  fs::path path = arguments.out;
  if (path.empty()) path = fs::path(arguments.recording).replace_extension("." + arguments.format);
  if (!holds_recording(path, arguments.recording)) return path;
  throw BadInput(
      fmt::format("{} is the recording, or holds it, and is not overwritten", path.string()));
}

/// @throws BadInput for what is there and may not be overwritten, or whose folder is not
fs::path target_of(const ExportArguments& arguments) {
  const fs::path target = path_of(arguments);
  const fs::path folder = target.has_parent_path() ? target.parent_path() : ".";
  if (!fs::is_directory(folder)) {
    throw BadInput(
        fmt::format("there is no folder {} for {}", folder.string(), target.filename().string()));
  }
  if (fs::exists(target) && !fs::is_regular_file(target)) {
    throw BadInput(fmt::format("{} is {}, and an MCAP is a file", target.string(),
                               fs::is_directory(target) ? "a folder" : "no file"));
  }
  if (fs::exists(target) && !arguments.force) {
    throw BadInput(fmt::format("{} exists; --force overwrites it", target.string()));
  }
  return target;
}

/// Whether the MCAP of it can be replayed as it is: of the relocate task only the recording can,
/// and an object from a mesh file has to be given.
bool replays_as_mcap(const recording::Recording& recording, const fs::path& mcap) {
  return !relocate::is_episode(recording) && !ros2::bag_metadata(mcap).at("object").empty() &&
         std::ranges::any_of(recording.frames, [](const recording::Frame& frame) {
           return hand::touching_fingers(frame.reading) >= 2;
         });
}

/// By the Python package, which has the libraries for it: becomes its command.
int export_by_python(const ExportArguments& arguments) {
  path_of(arguments);
  constexpr const char* kProgram =
      "import sys\n"
      "if sys.path[:1] == ['']: del sys.path[0]\n"  // modules in the current folder are not ours
      "try:\n"
      "    from palpate.export import main\n"
      "except ImportError as problem:\n"
      "    print(f\"palpate export: {problem}: it needs pip install 'palpate[export]'\", "
      "file=sys.stderr)\n"
      "    sys.exit(3)\n"
      "sys.exit(main())\n";
  std::vector<const char*> line = {"python3", "-c", kProgram, arguments.format.c_str(),
                                   arguments.recording.c_str()};
  if (!arguments.out.empty()) line.insert(line.end(), {"--out", arguments.out.c_str()});
  if (arguments.force) line.push_back("--force");
  if (arguments.json) line.push_back("--json");
  line.push_back(nullptr);
  std::fflush(nullptr);
  execvp(line.front(), const_cast<char* const*>(line.data()));
  throw BadInput(fmt::format("{}: there is no python3, whose package palpate[export] writes it",
                             arguments.format));
}

int export_recording(const ExportArguments& arguments) {
  if (arguments.format != "mcap") return export_by_python(arguments);
  const fs::path target = target_of(arguments);
  const auto recording = recording::read_recording(arguments.recording);
  std::optional<Notice> notice(std::in_place, "writing messages", arguments.json);
  const std::uint64_t messages = ros2::export_mcap(recording, target);
  notice.reset();
  if (arguments.json) {
    print_json(nlohmann::json{{"path", target.string()}, {"messages", messages}});
  } else {
    fmt::print("wrote {}: {} messages\n", target.string(), messages);
    if (replays_as_mcap(recording, target))
      fmt::print("Next: palpate replay {}\n", quoted(target.string()));
  }
  return kDone;
}

}  // namespace

void add_export(CLI::App& program, Command& chosen) {
  auto arguments = std::make_shared<ExportArguments>();
  auto& command =
      *program.add_subcommand("export", "Write a recording in a format that other programs read");
  command
      .add_option("format", arguments->format,
                  "mcap: messages of ROS 2; lerobot, minari: data sets to learn from")
      ->option_text("FORMAT")
      ->check(CLI::IsMember({"mcap", "lerobot", "minari"}))
      ->required();
  accept_folder_of_pick(
      *command
           .add_option("recording", arguments->recording, "recording.h5 of a pick, or its folder")
           ->option_text("RECORDING")
           ->required());
  command
      .add_option(
          "--out", arguments->out,
          "file or, of a data set, folder to write (default: beside the recording, with the "
          "format's ending)")
      ->option_text("PATH");
  command.add_flag("--force", arguments->force, "overwrite PATH");
  command.add_flag("--json", arguments->json, "print one JSON object on stdout");
  command.footer(
      "An MCAP of the profile ros2: joint states, contacts, transforms, wrench, estimates and\n"
      "events, without the truth. Foxglove, ros2 bag and the mcap and rosbags packages of Python\n"
      "read it; configs/foxglove.json is a layout for it (docs/ros2.md).\n"
      "Data sets of LeRobot (version 3) and Minari, one episode, one step a tick, are written by\n"
      "the Python package: pip install 'palpate[export]'. With --json, messages are their steps.\n"
      "python3 -m palpate.export makes one data set of several recordings (docs/python.md).\n\n"
      "Examples:\n"
      "  palpate export mcap out/pick-mug-2/recording.h5\n"
      "  palpate export mcap out/pick-mug-2/recording.h5 --out mug.mcap --json\n"
      "  palpate export lerobot out/pick-mug-2/recording.h5 --out mug-lerobot\n"
      "  palpate export minari out/pick-mug-2/recording.h5 --out mug-minari");
  command.callback(
      [arguments, &chosen] { chosen = [arguments] { return export_recording(*arguments); }; });
}

}  // namespace palpate::app
