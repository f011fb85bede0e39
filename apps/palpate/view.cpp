// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstdio>
#include <optional>

#include "common.hpp"
#include "given_command.hpp"
#include "hand_option.hpp"
#include "interface_option.hpp"
#include "live_view.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/recording/replay_page.hpp"
#include "replay_file.hpp"
#include "terminal.hpp"
#include "view_stream.hpp"

namespace palpate::app {
namespace {

namespace fs = std::filesystem;

struct ViewArguments {
  CommonOptions common;
  std::vector<std::string> recordings;
  ServerAddress address;
  bool live = false;
  StreamArguments stream;
};

void say_where(const ViewArguments& arguments, const std::string& key, const std::string& place) {
  if (arguments.common.json) {
    print_json(nlohmann::json{{key, place}});
  } else {
    fmt::print("{}\n", place);
  }
  std::fflush(stdout);
}

/// Serves the page until the program is interrupted.
void serve(const ViewArguments& arguments, const std::string& page) {
  PageServer server(page, arguments.address);
  say_where(arguments, "url", server.url());
  if (!arguments.common.quiet) fmt::print(stderr, "open it in a browser; Ctrl-C ends\n");
  server.run_until_interrupted();
}

/// The page of one recording, or of two beside one another.
std::string page_of(const std::vector<std::string>& recordings) {
  if (recordings.size() == 1) return replay_html(recordings[0], recordings[0]);
  return recording::compare_page(replay_html(recordings[0], recordings[0]),
                                 replay_html(recordings[1], recordings[1]),
                                 fmt::format("{} and {}", recordings[0], recordings[1]));
}

int view_live(const ViewArguments& arguments) {
  if (!arguments.recordings.empty() || !arguments.common.out.empty()) {
    throw BadInput(
        "--live shows a stream of ROS 2: it cannot be combined with a recording or --out");
  }
  StreamArguments stream = arguments.stream;
  stream.common = arguments.common;
  std::optional<LiveView> live;
  return view_stream(stream, [&]() -> LiveView& {
    live.emplace(arguments.address, true);
    say_where(arguments, "url", live->url());
    return *live;
  });
}

int view(const ViewArguments& arguments) {
  if (arguments.live) return view_live(arguments);
  std::optional<Notice> notice(std::in_place, "making the page", arguments.common.quiet);
  const std::string page = page_of(arguments.recordings);
  notice.reset();
  if (arguments.common.out.empty()) {
    serve(arguments, page);
    return kDone;
  }
  const auto output = claim_output(arguments.common, {"replay.html"});
  const fs::path file = output->path() / "replay.html";
  write_file_atomically(file, page);
  say_where(arguments, "page", file.string());
  print_next(arguments.common, fmt::format("open {} in a browser", quoted(file.string())));
  return kDone;
}

}  // namespace

void add_view(CLI::App& program, Command& chosen) {
  auto arguments = std::make_shared<ViewArguments>();
  auto& command =
      *program.add_subcommand("view", "Serve the replay page of a recording to a browser");
  accept_folder_of_pick(
      *command
           .add_option("recording", arguments->recordings,
                       "recording.h5 of a pick, or its folder; two are shown side by side")
           ->expected(0, 2));
  command.add_option("--port", arguments->address.port, "port to serve on; 0: any free port")
      ->check(in_range(0, 65535))
      ->capture_default_str();
  command
      .add_option("--host", arguments->address.host,
                  "IPv4 address to serve on; other machines need the token that is printed")
      ->option_text("ADDRESS")
      ->capture_default_str();
  auto* const live = command.add_flag(
      "--live", arguments->live, "show a moving hand behind ROS 2, and the estimates of its node");
  command.add_option("--object", arguments->stream.object, "with --live: object in the hand")
      ->type_name("O")
      ->capture_default_str()
      ->needs(live);
  add_hand_option(command, arguments->stream.hand).needs(live);
  command.add_option("--domain", arguments->stream.domain, "with --live: DDS domain")
      ->option_text("N")
      ->check(in_range(0, 232))
      ->needs(live);
  for (CLI::Option* const option : add_interface_options(command, arguments->stream.interface)) {
    option->needs(live);
  }
  add_best_effort_option(command, arguments->stream.interface)->needs(live);
  add_common_options(command, arguments->common, kOut);
  command.footer(
      "Serves the page that replays the recording, to this machine only, until interrupted. With\n"
      "--out it writes the page as DIR/replay.html and ends.\n\n"
      "Examples:\n"
      "  palpate view out/pick-mug-2/recording.h5\n"
      "  palpate view out/pick-mug-2/recording.h5 out/pick-mug-8/recording.h5\n"
      "  palpate view --live --object mug --hand shadow   # beside palpate ros2 estimate\n"
      "  palpate view out/pick-mug-2/recording.h5 --out pages");
  command.callback([arguments, &command, &chosen] {
    for (const char* const served : {"--port", "--host"}) {
      if (command.count("--out") > 0 && command.count(served) > 0) {
        throw CLI::ExcludesError("--out", served);
      }
    }
    if (arguments->recordings.empty() && !arguments->live) {
      throw CLI::RequiredError("RECORDING or --live");
    }
    chosen = [arguments] { return view(*arguments); };
  });
}

}  // namespace palpate::app
