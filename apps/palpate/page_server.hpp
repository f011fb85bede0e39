// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <string>
#include <string_view>
#include <vector>

namespace palpate::app {

/// Answers browsers on this machine with one page, in one thread that waits for none of them.
///
/// A small part of HTTP/1.1 (RFC 9112): GET and HEAD of "/", each answered whole, whatever its
/// Range, and then closed. A request must name this server as its Host and, if it names one, as its
/// Origin, so that no page from elsewhere can read this one. All connections share the page's
/// bytes; each holds at most kMaxHead bytes beside. Who is slow is closed after a while, or when
/// its place is needed.
class PageServer {
 public:
  static constexpr std::size_t kMaxHead = 8192;        ///< bytes of a request
  static constexpr std::size_t kMaxConnections = 400;  ///< at once

  /// Listens on 127.0.0.1. @param port  0 takes a free one
  /// @throws BadInput if the port is taken
  PageServer(std::string_view page, int port);
  ~PageServer();
  PageServer(const PageServer&) = delete;
  PageServer& operator=(const PageServer&) = delete;

  int port() const { return port_; }

  /// Serves until SIGINT or SIGTERM arrives.
  void run_until_interrupted();

 private:
  using Clock = std::chrono::steady_clock;
  enum class Stage { reading, writing, draining, over };

  struct Connection {
    int socket = -1;
    Stage stage = Stage::reading;
    std::string head;       ///< of the request, then of the answer
    std::string_view body;  ///< of the answer, what is left of it
    std::size_t sent = 0;   ///< of the answer's head
    Clock::time_point end;  ///< when it is closed in any case
  };

  void accept_all();
  void make_room();
  void serve(Connection& connection) const;
  void read_request(Connection& connection) const;
  void write_answer(Connection& connection) const;
  void drain(Connection& connection) const;
  void close_finished();
  std::string answer_to(std::string_view request, std::string_view& body) const;

  std::string_view page_;
  int listener_ = -1, port_ = 0;
  std::vector<Connection> connections_;  // the oldest first
};

}  // namespace palpate::app
