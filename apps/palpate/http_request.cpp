// SPDX-License-Identifier: Apache-2.0
#include "http_request.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <random>
#include <system_error>

#include "palpate/core/csv.hpp"

namespace palpate::app {
namespace {

std::string_view take_until(std::string_view& rest, std::string_view end) {
  const auto at = std::min(rest.find(end), rest.size());
  const auto front = rest.substr(0, at);
  rest.remove_prefix(std::min(at + end.size(), rest.size()));
  return front;
}

bool is_name(std::string_view text, std::string_view name) {
  return std::ranges::equal(text, name, [](unsigned char a, unsigned char b) {
    return std::tolower(a) == std::tolower(b);
  });
}

/// Whether an authority (HOST:PORT) is this machine's.
bool is_here(std::string_view authority, const ServerSide& side) {
  const std::array<std::string_view, 3> names = {"127.0.0.1", "localhost", side.host};
  return std::ranges::any_of(names, [&](std::string_view name) {
    return authority == fmt::format("{}:{}", name, side.port) ||
           (side.port == 80 && authority == name);
  });
}

std::string_view parameter(std::string_view query, std::string_view name) {
  while (!query.empty()) {
    std::string_view pair = take_until(query, "&");
    if (take_until(pair, "=") == name) return pair;
  }
  return {};
}

/// Takes the same time wherever they differ.
bool same(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned differences = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    differences |= static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i]);
  }
  return differences == 0;
}

/// Whether the request may have the page at all.
bool may_see(const HttpRequest& request, const ServerSide& side) {
  if (request.origin && *request.origin != fmt::format("http://{}", *request.host)) return false;
  if (side.token.empty()) return is_here(*request.host, side);
  return same(parameter(request.query, "token"), side.token);
}

constexpr std::string_view kGuards =
    "X-Content-Type-Options: nosniff\r\nCross-Origin-Resource-Policy: same-origin\r\n"
    "Referrer-Policy: no-referrer\r\nCache-Control: no-store\r\n";

}  // namespace

HttpRequest parse_request(std::string_view head) {
  HttpRequest request;
  std::string_view line = take_until(head, "\r\n");
  request.method = take_until(line, " ");
  request.query = take_until(line, " ");
  request.path = take_until(request.query, "?");
  request.well_formed = line.starts_with("HTTP/1.") && !request.path.empty();
  for (line = take_until(head, "\r\n"); !line.empty(); line = take_until(head, "\r\n")) {
    const std::string_view name = take_until(line, ":");
    const std::string_view value = trimmed(line);
    auto* const field = is_name(name, "host")            ? &request.host
                        : is_name(name, "origin")        ? &request.origin
                        : is_name(name, "last-event-id") ? &request.last_event_id
                                                         : nullptr;
    if (!field) continue;
    if (field->has_value()) request.well_formed = false;  // which of the two would count?
    *field = value;
  }
  return request;
}

HttpStatus status_of(const HttpRequest& request, const ServerSide& side) {
  if (!request.well_formed || !request.host) return {400, "Bad Request"};
  if (!may_see(request, side)) return {403, "Forbidden"};
  if (request.method != "GET" && request.method != "HEAD") return {405, "Method Not Allowed"};
  if (request.path == "/") return {200, "OK"};
  if (request.path == "/events" && side.streams && request.method == "GET") return {200, "OK"};
  return {404, "Not Found"};
}

std::string message_id(std::string_view run, std::uint64_t number) {
  return fmt::format("{}-{}", run, number);
}

std::optional<std::uint64_t> last_message(const HttpRequest& request, std::string_view run) {
  if (!request.last_event_id) return std::nullopt;
  std::string_view text = *request.last_event_id;
  if (take_until(text, "-") != run) return std::nullopt;
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

std::string answer_head(HttpStatus status, std::size_t size) {
  return fmt::format(
      "HTTP/1.1 {} {}\r\nContent-Type: text/html; charset=utf-8\r\nContent-Length: {}\r\n"
      "{}{}Connection: close\r\n\r\n",
      status.code, status.reason, size, kGuards, status.code == 405 ? "Allow: GET, HEAD\r\n" : "");
}

std::string stream_head() {
  return fmt::format(
      "HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\n{}Connection: close\r\n\r\n", kGuards);
}

std::string random_token() {
  std::random_device random;
  return fmt::format("{:08x}{:08x}{:08x}{:08x}", random(), random(), random(), random());
}

}  // namespace palpate::app
