// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "common.hpp"
#include "palpate/core/error.hpp"
#include "palpate/ros2/export_recording.hpp"

namespace palpate::app {
namespace {

namespace fs = std::filesystem;

struct ExportArguments {
  std::string format, recording, out;
  bool force = false, json = false;
};

/// @throws BadInput for a file that is there and may not be overwritten
fs::path target_of(const ExportArguments& arguments) {
  fs::path target = arguments.out;
  if (target.empty()) target = fs::path(arguments.recording).replace_extension(".mcap");
  if (fs::exists(target) && !arguments.force) {
    throw BadInput(fmt::format("{} exists; --force overwrites it", target.string()));
  }
  return target;
}

int export_recording(const ExportArguments& arguments) {
  const auto recording = recording::read_recording(arguments.recording);
  const fs::path target = target_of(arguments);
  const std::uint64_t messages = ros2::export_mcap(recording, target);
  if (arguments.json) {
    fmt::print("{}\n", nlohmann::json{{"path", target.string()}, {"messages", messages}}.dump(2));
  } else {
    fmt::print("wrote {}: {} messages\n", target.string(), messages);
  }
  return kDone;
}

}  // namespace

void add_export(CLI::App& program, Command& chosen) {
  auto arguments = std::make_shared<ExportArguments>();
  auto& command =
      *program.add_subcommand("export", "Write a recording in a format that other programs read");
  command.add_option("format", arguments->format, "mcap: messages of ROS 2")
      ->option_text("FORMAT")
      ->check(CLI::IsMember({"mcap"}))
      ->required();
  command.add_option("recording", arguments->recording, "recording.h5 of a pick")
      ->option_text("RECORDING")
      ->required();
  command
      .add_option("--out", arguments->out,
                  "file to write (default: beside the recording, with the format's ending)")
      ->option_text("FILE");
  command.add_flag("--force", arguments->force, "overwrite FILE");
  command.add_flag("--json", arguments->json, "print one JSON object on stdout");
  command.footer(
      "An MCAP of the profile ros2: joint states, contacts, transforms, wrench, estimates and\n"
      "events, without the truth. Foxglove, ros2 bag and the mcap and rosbags packages of Python\n"
      "read it; configs/foxglove.json is a layout for it (docs/ros2.md).\n\n"
      "Examples:\n"
      "  palpate export mcap out/pick-mug-7/recording.h5\n"
      "  palpate export mcap out/pick-mug-7/recording.h5 --out mug.mcap --json");
  command.callback(
      [arguments, &chosen] { chosen = [arguments] { return export_recording(*arguments); }; });
}

}  // namespace palpate::app
