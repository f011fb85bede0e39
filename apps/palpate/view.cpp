// SPDX-License-Identifier: Apache-2.0
// cpp-httplib breaks Eigen's headers if they come after it, so it is the last include.
#include <fmt/format.h>

#include <csignal>
#include <thread>

#include "common.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "replay_file.hpp"
//
#include <httplib.h>

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
  sigset_t interrupts;
  sigemptyset(&interrupts);
  sigaddset(&interrupts, SIGINT);
  sigaddset(&interrupts, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &interrupts, nullptr);  // the server's threads inherit this

  httplib::Server server;
  // Its default, SO_REUSEPORT, would share a port that is already served.
  server.set_socket_options([](socket_t socket) {
    const int yes = 1;
    setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  });
  server.Get("/", [&page](const httplib::Request&, httplib::Response& response) {
    response.set_content(page, "text/html; charset=utf-8");
  });
  const int port = arguments.port == 0 ? server.bind_to_any_port("127.0.0.1")
                   : server.bind_to_port("127.0.0.1", arguments.port) ? arguments.port
                                                                      : -1;
  if (port < 0) {
    throw BadInput(
        fmt::format("cannot listen on port {}; --port 0 takes a free one", arguments.port));
  }
  say_where(arguments, "url", fmt::format("http://127.0.0.1:{}/", port));
  if (!arguments.common.quiet) fmt::print(stderr, "open it in a browser; Ctrl-C ends\n");
  std::thread listener([&server] { server.listen_after_bind(); });
  int interrupt = 0;
  sigwait(&interrupts, &interrupt);
  server.stop();
  listener.join();
}

int view(const ViewArguments& arguments) {
  const std::string page = replay_html(arguments.recording, arguments.recording);
  if (arguments.common.out.empty()) {
    serve(arguments, page);
    return kDone;
  }
  const fs::path file = fs::path(arguments.common.out) / "replay.html";
  write_file_atomically(file, page);
  say_where(arguments, "page", file.string());
  return kDone;
}

}  // namespace

void add_view(CLI::App& program, Command& chosen) {
  auto arguments = std::make_shared<ViewArguments>();
  auto& command = *program.add_subcommand("view", "Show a recording in the browser");
  command.add_option("recording", arguments->recording, "recording.h5 of a pick")->required();
  command.add_option("--port", arguments->port, "to serve on; 0 takes a free one")
      ->check(CLI::Range(0, 65535))
      ->capture_default_str();
  add_common_options(command, arguments->common);
  command.footer(
      "Serves the page that replays the recording, to this machine only, until interrupted. With\n"
      "--out it writes the page as DIR/replay.html and ends.\n\n"
      "Examples:\n"
      "  palpate view out/pick-mug-7/recording.h5\n"
      "  palpate view out/pick-mug-7/recording.h5 --out pages");
  command.callback([arguments, &chosen] { chosen = [arguments] { return view(*arguments); }; });
}

}  // namespace palpate::app
