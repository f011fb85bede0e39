// SPDX-License-Identifier: Apache-2.0
#include "page_server.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/signalfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <system_error>

#include "http_request.hpp"
#include "palpate/core/error.hpp"

namespace palpate::app {
namespace {

using std::chrono::seconds;

constexpr seconds kRequestTime{5}, kAnswerTime{120}, kDrainTime{1};
constexpr int kTick = 250;  // ms, at least so often those that are over time are looked for

int listen_on(int port) {
  const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  const int yes = 1;
  setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 &&
      listen(socket, SOMAXCONN) == 0) {
    return socket;
  }
  const std::string reason = std::generic_category().message(errno);
  if (socket >= 0) ::close(socket);
  throw BadInput(
      fmt::format("cannot listen on port {} ({}); --port 0 takes a free one", port, reason));
}

int port_of(int socket) {
  sockaddr_in address{};
  socklen_t size = sizeof address;
  getsockname(socket, reinterpret_cast<sockaddr*>(&address), &size);
  return ntohs(address.sin_port);
}

/// A descriptor that is readable once the program is to end.
int interrupt_descriptor() {
  sigset_t interrupts;
  sigemptyset(&interrupts);
  sigaddset(&interrupts, SIGINT);
  sigaddset(&interrupts, SIGTERM);
  sigprocmask(SIG_BLOCK, &interrupts, nullptr);
  return signalfd(-1, &interrupts, SFD_CLOEXEC);
}

bool would_wait() { return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR; }

}  // namespace

PageServer::PageServer(std::string_view page, int port)
    : page_(page), listener_(listen_on(port)), port_(port_of(listener_)) {}

PageServer::~PageServer() {
  for (const auto& connection : connections_) ::close(connection.socket);
  ::close(listener_);
}

void PageServer::run_until_interrupted() {
  const int interrupt = interrupt_descriptor();
  std::vector<pollfd> waiting;
  while (true) {
    waiting = {{interrupt, POLLIN, 0}, {listener_, POLLIN, 0}};
    for (const auto& connection : connections_) {
      const bool writes = connection.stage == Stage::writing;
      waiting.push_back({connection.socket, static_cast<short>(writes ? POLLOUT : POLLIN), 0});
    }
    poll(waiting.data(), waiting.size(), kTick);
    if (waiting[0].revents != 0) break;
    for (std::size_t i = 0; i < connections_.size(); ++i) {
      if (waiting[i + 2].revents != 0) serve(connections_[i]);
    }
    close_finished();
    if (waiting[1].revents != 0) accept_all();
  }
  ::close(interrupt);
}

void PageServer::accept_all() {
  for (std::size_t i = 0; i < kMaxConnections; ++i) {
    if (connections_.size() >= kMaxConnections) make_room();
    const int socket = accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (socket < 0 && (errno == EMFILE || errno == ENFILE) && !connections_.empty()) make_room();
    if (socket < 0) return;
    connections_.push_back({socket, Stage::reading, "", {}, 0, Clock::now() + kRequestTime});
    serve(connections_.back());
  }
}

/// Closes the oldest connection that is still asking, or else the oldest.
void PageServer::make_room() {
  auto oldest = std::ranges::find(connections_, Stage::reading, &Connection::stage);
  if (oldest == connections_.end()) oldest = connections_.begin();
  ::close(oldest->socket);
  connections_.erase(oldest);
}

void PageServer::serve(Connection& connection) const {
  if (connection.stage == Stage::reading) read_request(connection);
  if (connection.stage == Stage::writing) write_answer(connection);
  if (connection.stage == Stage::draining) drain(connection);
}

void PageServer::read_request(Connection& connection) const {
  std::array<char, kMaxHead> buffer;
  const std::size_t room = kMaxHead - connection.head.size();
  const auto size = recv(connection.socket, buffer.data(), room, 0);
  if (size < 0 && would_wait()) return;
  if (size <= 0) {
    connection.stage = Stage::over;
    return;
  }
  connection.head.append(buffer.data(), static_cast<std::size_t>(size));
  const bool whole = connection.head.find("\r\n\r\n") != std::string::npos;
  if (!whole && connection.head.size() < kMaxHead) return;
  connection.head = whole ? answer_to(connection.head, connection.body)
                          : answer_head({431, "Request Header Fields Too Large"}, 0);
  connection.stage = Stage::writing;
  connection.end = Clock::now() + kAnswerTime;
}

std::string PageServer::answer_to(std::string_view request, std::string_view& body) const {
  const HttpRequest parsed = parse_request(request);
  const HttpStatus status = status_of(parsed, port_);
  if (status.code != 200) return answer_head(status, 0);
  if (parsed.method == "GET") body = page_;
  return answer_head(status, page_.size());
}

void PageServer::write_answer(Connection& connection) const {
  while (true) {
    const std::string_view head = std::string_view(connection.head).substr(connection.sent);
    const std::string_view next = head.empty() ? connection.body : head;
    if (next.empty()) break;
    const auto size = send(connection.socket, next.data(), next.size(), MSG_NOSIGNAL);
    if (size < 0 && would_wait()) return;
    if (size < 0) {
      connection.stage = Stage::over;
      return;
    }
    if (head.empty()) {
      connection.body.remove_prefix(static_cast<std::size_t>(size));
    } else {
      connection.sent += static_cast<std::size_t>(size);
    }
  }
  shutdown(connection.socket, SHUT_WR);
  connection.stage = Stage::draining;  // to close at once would reset what is on its way
  connection.end = Clock::now() + kDrainTime;
}

void PageServer::drain(Connection& connection) const {
  std::array<char, 4096> buffer;
  const auto size = recv(connection.socket, buffer.data(), buffer.size(), 0);
  if (size == 0 || (size < 0 && !would_wait())) connection.stage = Stage::over;
}

void PageServer::close_finished() {
  const auto now = Clock::now();
  std::erase_if(connections_, [now](const Connection& connection) {
    const bool finished = connection.stage == Stage::over || now > connection.end;
    if (finished) ::close(connection.socket);
    return finished;
  });
}

}  // namespace palpate::app
