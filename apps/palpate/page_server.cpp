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
#include <charconv>
#include <csignal>
#include <system_error>

#include "http_request.hpp"
#include "palpate/core/error.hpp"

namespace palpate::app {
namespace {

using std::chrono::seconds;

constexpr seconds kRequestTime{5}, kAnswerTime{120}, kDrainTime{1}, kStallTime{30};
constexpr int kTick = 250;  // ms, at least so often those that are over time are looked for

/// @throws BadInput unless the host is an IPv4 address
sockaddr_in socket_address(const ServerAddress& address) {
  sockaddr_in result{};
  result.sin_family = AF_INET;
  result.sin_port = htons(static_cast<std::uint16_t>(address.port));
  if (inet_pton(AF_INET, address.host.c_str(), &result.sin_addr) == 1) return result;
  throw BadInput(
      fmt::format("{:?} is no IPv4 address; 127.0.0.1 is this machine alone, 0.0.0.0 "
                  "all of its interfaces",
                  address.host));
}

bool is_loopback(const sockaddr_in& address) {
  constexpr unsigned kLoopback = 127;
  return ntohl(address.sin_addr.s_addr) >> 24 == kLoopback;
}

int listen_on(const sockaddr_in& address) {
  const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  const int yes = 1;
  setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  if (bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 &&
      listen(socket, SOMAXCONN) == 0) {
    return socket;
  }
  const std::string reason = std::generic_category().message(errno);
  if (socket >= 0) ::close(socket);
  throw BadInput(fmt::format("cannot listen on port {} ({}); port 0 takes a free one",
                             ntohs(address.sin_port), reason));
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

ServerAddress parse_address(const std::string& text) {
  ServerAddress address;
  const auto colon = text.rfind(':');
  if (colon != std::string::npos) address.host = text.substr(0, colon);
  const std::string port = colon == std::string::npos ? text : text.substr(colon + 1);
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), address.port);
  constexpr int kMaxPort = 65535;
  if (error != std::errc() || end != port.data() + port.size() || address.port < 0 ||
      address.port > kMaxPort) {
    throw BadInput(fmt::format("{:?} is no address: it is PORT or HOST:PORT", text));
  }
  return address;
}

PageServer::PageServer(std::string page, const ServerAddress& address)
    : page_(std::make_shared<const std::string>(std::move(page))) {
  const sockaddr_in where = socket_address(address);
  listener_ = listen_on(where);
  side_ = {address.host, port_of(listener_), is_loopback(where) ? "" : random_token(), false};
}

PageServer::PageServer(const MessageLog& log, const ServerAddress& address)
    : PageServer("", address) {
  log_ = &log;
  side_.streams = true;
}

PageServer::~PageServer() {
  for (const auto& connection : connections_) ::close(connection.socket);
  ::close(listener_);
}

std::string PageServer::url() const {
  return fmt::format("http://{}:{}/{}", side_.host, side_.port,
                     side_.token.empty() ? "" : "?token=" + side_.token);
}

void PageServer::run_until_interrupted() {
  const int interrupt = interrupt_descriptor();
  run_until(interrupt);
  ::close(interrupt);
}

void PageServer::run_until(int descriptor, std::chrono::milliseconds drain) {
  pollfd ended{descriptor, POLLIN, 0};
  while (poll(&ended, 1, 0) <= 0) turn(descriptor);
  const auto end = Clock::now() + drain;
  while (Clock::now() < end && !all_sent()) turn(-1);
}

/// One round of what is to be done for everybody.
void PageServer::turn(int descriptor) {
  std::vector<pollfd> waiting = {
      {descriptor, POLLIN, 0}, {listener_, POLLIN, 0}, {log_ ? log_->descriptor() : -1, POLLIN, 0}};
  const std::size_t first = waiting.size();
  for (const auto& connection : connections_) {
    const bool writes = connection.stage == Stage::writing ||
                        (connection.stage == Stage::streaming && !connection.waits);
    waiting.push_back({connection.socket, static_cast<short>(writes ? POLLOUT : POLLIN), 0});
  }
  poll(waiting.data(), waiting.size(), kTick);
  const bool news = waiting[2].revents != 0;
  if (news) log_->acknowledge();
  for (std::size_t i = 0; i < connections_.size(); ++i) {
    const bool streams = connections_[i].stage == Stage::streaming;
    if (waiting[i + first].revents != 0 || (news && streams)) serve(connections_[i]);
  }
  close_finished();
  if (waiting[1].revents != 0) accept_all();
}

bool PageServer::all_sent() const {
  return std::ranges::all_of(connections_, [](const Connection& connection) {
    return connection.stage == Stage::streaming ? connection.waits
                                                : connection.stage == Stage::reading;
  });
}

void PageServer::accept_all() {
  for (std::size_t i = 0; i < kMaxConnections; ++i) {
    if (connections_.size() >= kMaxConnections) make_room();
    const int socket = accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (socket < 0 && (errno == EMFILE || errno == ENFILE) && !connections_.empty()) make_room();
    if (socket < 0) return;
    connections_.push_back({});
    connections_.back().socket = socket;
    connections_.back().end = Clock::now() + kRequestTime;
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
  if (connection.stage == Stage::streaming) stream(connection);
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
  connection.stage = Stage::writing;
  connection.end = Clock::now() + kAnswerTime;
  if (whole) {
    answer(connection);
  } else {
    connection.head = answer_head({431, "Request Header Fields Too Large"}, 0);
  }
}

void PageServer::answer(Connection& connection) const {
  const std::string text = std::move(connection.head);
  const HttpRequest request = parse_request(text);
  const HttpStatus status = status_of(request, side_);
  if (status.code != 200) {
    connection.head = answer_head(status, 0);
  } else if (request.path == "/events") {
    const auto [first, end] = log_->range();
    const auto last = last_message(request, run_);
    // A number of another page's, or of another run: from the beginning.
    connection.next = last && *last >= first && *last < end ? *last + 1 : first;
    connection.head = stream_head();
    connection.stage = Stage::streaming;
  } else {
    const auto page = log_ ? log_->page() : page_;
    connection.head = answer_head(status, page->size());
    if (request.method == "GET") connection.body = page;
  }
}

/// @return whether all of head and body has been sent
bool PageServer::write_some(Connection& connection) const {
  while (true) {
    const bool in_head = connection.sent < connection.head.size();
    const std::string_view whole = in_head           ? std::string_view(connection.head)
                                   : connection.body ? std::string_view(*connection.body)
                                                     : std::string_view();
    const auto next =
        whole.substr(in_head ? connection.sent
                             : std::min(whole.size(), connection.sent - connection.head.size()));
    if (next.empty()) return true;
    const auto size = send(connection.socket, next.data(), next.size(), MSG_NOSIGNAL);
    if (size < 0 && would_wait()) return false;
    if (size < 0) {
      connection.stage = Stage::over;
      return false;
    }
    connection.sent += static_cast<std::size_t>(size);
  }
}

void PageServer::write_answer(Connection& connection) const {
  if (!write_some(connection)) return;
  shutdown(connection.socket, SHUT_WR);
  connection.stage = Stage::draining;  // to close at once would reset what is on its way
  connection.end = Clock::now() + kDrainTime;
}

/// Takes up the next message of the stream. @return false if there is none yet
bool PageServer::next_message(Connection& connection) const {
  auto [message, number] = log_->from(connection.next);
  if (!message) return false;
  connection.head = fmt::format("\nid: {}\ndata: ", message_id(run_, number));
  connection.body = std::move(message);
  connection.sent = 0;
  connection.next = number + 1;
  return true;
}

void PageServer::stream(Connection& connection) const {
  std::array<char, 4096> ignored;
  const auto size = recv(connection.socket, ignored.data(), ignored.size(), 0);
  if (size == 0 || (size < 0 && !would_wait())) {
    connection.stage = Stage::over;  // gone
    return;
  }
  while (write_some(connection)) {
    connection.end = Clock::now() + kStallTime;
    if (connection.next < log_->range().first) {  // another page has begun
      connection.stage = Stage::over;
      return;
    }
    connection.waits = !next_message(connection);
    if (connection.waits) return;
  }
}

void PageServer::drain(Connection& connection) const {
  std::array<char, 4096> buffer;
  const auto size = recv(connection.socket, buffer.data(), buffer.size(), 0);
  if (size == 0 || (size < 0 && !would_wait())) connection.stage = Stage::over;
}

void PageServer::close_finished() {
  const auto now = Clock::now();
  std::erase_if(connections_, [now](const Connection& connection) {
    const bool idle = connection.stage == Stage::streaming && connection.waits;
    const bool finished = connection.stage == Stage::over || (now > connection.end && !idle);
    if (finished) ::close(connection.socket);
    return finished;
  });
}

}  // namespace palpate::app
