// SPDX-License-Identifier: Apache-2.0
#include "live_view.hpp"

#include <fmt/format.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <cstdio>
#include <nlohmann/json.hpp>
#include <utility>

#include "palpate/core/assets.hpp"
#include "palpate/core/file.hpp"
#include "replay_file.hpp"

namespace palpate::app {
namespace {

constexpr std::chrono::milliseconds kLastWords{2000};

}  // namespace

LiveView::LiveView(const ServerAddress& address, bool quiet)
    : server_(log_, address), ended_(eventfd(0, EFD_CLOEXEC)) {
  log_.begin(
      "<!doctype html><meta http-equiv=refresh content=1><title>palpate</title>"
      "<p>Nothing to show yet.");
  if (!quiet) fmt::print(stderr, "live: {}\n", server_.url());
  thread_ = std::thread([this] { server_.run_until(ended_, kLastWords); });
}

LiveView::~LiveView() {
  const std::uint64_t one = 1;
  static_cast<void>(!write(ended_, &one, sizeof one));
  thread_.join();
  ::close(ended_);
}

std::unique_ptr<recording::PageStream> LiveView::begin(
    const recording::RecordingHeader& header, const std::string& title,
    const recording::PageStream::Options& options) {
  const std::uint64_t page = ++pages_;
  log_.begin(recording::live_page(header, visuals_of(header.hand), read_file(asset("page.html")),
                                  read_file(asset("viewer.js")), title));
  const auto send = [this, page](const std::string& message) {
    if (page == pages_) log_.add(message + "\n\n");
  };
  send(nlohmann::json{{"page", random_token()}}.dump());
  return std::make_unique<recording::PageStream>(header, send, options);
}

std::unique_ptr<LiveView> LiveOption::open(bool quiet) const {
  if (option->count() == 0) return nullptr;
  return std::make_unique<LiveView>(parse_address(address), quiet);
}

void add_live_option(CLI::App& command, LiveOption& live) {
  live.option = command
                    .add_option("--live", live.address,
                                "show the run live in a browser, on this port of this machine; "
                                "with a host also to other machines, which need the token that "
                                "is printed")
                    ->option_text("[[HOST:]PORT]")
                    ->expected(0, 1)
                    ->capture_default_str();
}

}  // namespace palpate::app
