// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstdio>

#include "common.hpp"
#include "page_server.hpp"
#include "palpate/core/file.hpp"
#include "replay_file.hpp"

namespace palpate::app {
namespace {

namespace fs = std::filesystem;

struct ViewArguments {
  CommonOptions common;
  std::string recording;
  int port = 8080;
};

void say_where(const ViewArguments& arguments, const std::string& key, const std::string& place) {
  if (arguments.common.json) {
    fmt::print("{}\n", nlohmann::json{{key, place}}.dump(2));
  } else {
    fmt::print("{}\n", place);
  }
  std::fflush(stdout);
}

/// Serves the page on this machine only, until the program is interrupted.
void serve(const ViewArguments& arguments, const std::string& page) {
  PageServer server(page, arguments.port);
  say_where(arguments, "url", fmt::format("http://127.0.0.1:{}/", server.port()));
  if (!arguments.common.quiet) fmt::print(stderr, "open it in a browser; Ctrl-C ends\n");
  server.run_until_interrupted();
}

int view(const ViewArguments& arguments) {
  const std::string page = replay_html(arguments.recording, arguments.recording);
  if (arguments.common.out.empty()) {
    serve(arguments, page);
    return kDone;
  }
  const auto output = claim_output(arguments.common, {"replay.html"});
  const fs::path file = output->path() / "replay.html";
  write_file_atomically(file, page);
  say_where(arguments, "page", file.string());
  return kDone;
}

}  // namespace

void add_view(CLI::App& program, Command& chosen) {
  auto arguments = std::make_shared<ViewArguments>();
  auto& command =
      *program.add_subcommand("view", "Serve the replay page of a recording to a browser");
  command.add_option("recording", arguments->recording, "recording.h5 of a pick")->required();
  command.add_option("--port", arguments->port, "port to serve on; 0: any free port")
      ->check(in_range(0, 65535))
      ->capture_default_str();
  add_common_options(command, arguments->common, kOut);
  command.footer(
      "Serves the page that replays the recording, to this machine only, until interrupted. With\n"
      "--out it writes the page as DIR/replay.html and ends.\n\n"
      "Examples:\n"
      "  palpate view out/pick-mug-7/recording.h5\n"
      "  palpate view out/pick-mug-7/recording.h5 --out pages");
  command.callback([arguments, &chosen] { chosen = [arguments] { return view(*arguments); }; });
}

}  // namespace palpate::app
