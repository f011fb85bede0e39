// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <atomic>
#include <memory>
#include <string>
#include <thread>

#include "page_server.hpp"
#include "palpate/recording/page_stream.hpp"

namespace palpate::app {

/// Shows what happens to browsers while it happens, from a thread of its own.
class LiveView {
 public:
  /// Says on stderr where, unless `quiet`. @throws BadInput for an address that cannot be served
  LiveView(const ServerAddress& address, bool quiet);
  /// Gives those that watch two seconds to get all that they lack.
  ~LiveView();
  LiveView(const LiveView&) = delete;
  LiveView& operator=(const LiveView&) = delete;

  std::string url() const { return server_.url(); }

  /// Shows another recording from now on; what the last one sends goes nowhere.
  /// @param title  plain text
  std::unique_ptr<recording::PageStream> begin(const recording::RecordingHeader& header,
                                               const std::string& title,
                                               const recording::PageStream::Options& options = {});

 private:
  MessageLog log_;
  PageServer server_;
  int ended_ = -1;
  std::atomic<std::uint64_t> pages_ = 0;
  std::thread thread_;
};

/// --live [[HOST:]PORT]: the address, and whether it is asked for.
struct LiveOption {
  std::string address = "8080";
  CLI::Option* option = nullptr;

  /// The view, if it is asked for. @throws BadInput for an address that cannot be served
  std::unique_ptr<LiveView> open(bool quiet) const;
};
void add_live_option(CLI::App& command, LiveOption& live);

}  // namespace palpate::app
