// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "http_request.hpp"
#include "message_log.hpp"

namespace palpate::app {

/// Where a page is served.
struct ServerAddress {
  std::string host = "127.0.0.1";  ///< IPv4 address of an interface; 0.0.0.0: all
  int port = 8080;                 ///< 0: any free one
};

/// [HOST:]PORT. @throws BadInput for anything else
ServerAddress parse_address(const std::string& text);

/// Answers browsers with one page and, where there is a log of messages, with these as they come
/// (server-sent events), in one thread that waits for none of them.
///
/// A small part of HTTP/1.1 (RFC 9112): GET and HEAD of "/", each answered whole, whatever its
/// Range, and then closed; GET of "/events", which goes on. On the loopback a request must name
/// this server as its Host and, if it names one, as its Origin, so that no page from elsewhere can
/// read this one; beyond it a request must have the token that url() has. All connections share the
/// bytes of page and messages; each holds at most kMaxHead bytes beside. Who is slow is closed
/// after a while, or when its place is needed.
class PageServer {
 public:
  static constexpr std::size_t kMaxHead = 8192;        ///< bytes of a request
  static constexpr std::size_t kMaxConnections = 400;  ///< at once

  /// Serves a page that does not change. @throws BadInput if the address is taken, or none
  PageServer(std::string page, const ServerAddress& address);
  /// Serves the page and the messages of a log that outlives it.
  PageServer(const MessageLog& log, const ServerAddress& address);
  ~PageServer();
  PageServer(const PageServer&) = delete;
  PageServer& operator=(const PageServer&) = delete;

  std::string url() const;

  /// Serves until SIGINT or SIGTERM arrives.
  void run_until_interrupted();
  /// Serves until a descriptor is readable, and then until all that watch have everything, for
  /// `drain` at most.
  void run_until(int descriptor, std::chrono::milliseconds drain = {});

 private:
  using Clock = std::chrono::steady_clock;
  enum class Stage { reading, writing, streaming, draining, over };

  struct Connection {
    int socket = -1;
    Stage stage = Stage::reading;
    std::string head;                         ///< of the request, then of the answer
    std::shared_ptr<const std::string> body;  ///< of the answer, or the message under way
    std::size_t sent = 0;                     ///< of head and body together
    std::uint64_t next = 0;                   ///< message of a stream
    bool waits = false;                       ///< for messages, all that there are having been sent
    Clock::time_point end;                    ///< when it is closed in any case
  };

  void turn(int descriptor);
  void accept_all();
  void make_room();
  void serve(Connection& connection) const;
  void read_request(Connection& connection) const;
  void answer(Connection& connection) const;
  void write_answer(Connection& connection) const;
  void stream(Connection& connection) const;
  bool next_message(Connection& connection) const;
  bool write_some(Connection& connection) const;
  void drain(Connection& connection) const;
  void close_finished();
  bool all_sent() const;

  std::shared_ptr<const std::string> page_;  // where there is no log
  const MessageLog* log_ = nullptr;
  ServerSide side_;
  std::string run_ = random_token();  // in the ids of messages, whose numbers each run begins at 0
  int listener_ = -1;
  std::vector<Connection> connections_;  // the oldest first
};

}  // namespace palpate::app
