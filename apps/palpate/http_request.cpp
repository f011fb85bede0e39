// SPDX-License-Identifier: Apache-2.0
#include "http_request.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>

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

/// Whether an authority (HOST:PORT) is this server's.
bool is_here(std::string_view authority, int port) {
  constexpr std::array<std::string_view, 2> kNames = {"127.0.0.1", "localhost"};
  return std::ranges::any_of(kNames, [&](std::string_view name) {
    return authority == fmt::format("{}:{}", name, port) || (port == 80 && authority == name);
  });
}

}  // namespace

HttpRequest parse_request(std::string_view head) {
  HttpRequest request;
  std::string_view line = take_until(head, "\r\n");
  request.method = take_until(line, " ");
  request.target = take_until(line, " ");
  request.well_formed = line.starts_with("HTTP/1.") && !request.target.empty();
  for (line = take_until(head, "\r\n"); !line.empty(); line = take_until(head, "\r\n")) {
    const std::string_view name = take_until(line, ":");
    const std::string_view value = trimmed(line);
    auto* const field = is_name(name, "host")     ? &request.host
                        : is_name(name, "origin") ? &request.origin
                                                  : nullptr;
    if (!field) continue;
    if (field->has_value()) request.well_formed = false;  // which of the two would count?
    *field = value;
  }
  return request;
}

HttpStatus status_of(const HttpRequest& request, int port) {
  if (!request.well_formed || !request.host) return {400, "Bad Request"};
  if (!is_here(*request.host, port)) return {403, "Forbidden"};
  if (request.origin && *request.origin != fmt::format("http://{}", *request.host)) {
    return {403, "Forbidden"};
  }
  if (request.method != "GET" && request.method != "HEAD") return {405, "Method Not Allowed"};
  if (request.target != "/" && !request.target.starts_with("/?")) return {404, "Not Found"};
  return {200, "OK"};
}

std::string answer_head(HttpStatus status, std::size_t size) {
  return fmt::format(
      "HTTP/1.1 {} {}\r\nContent-Type: text/html; charset=utf-8\r\nContent-Length: {}\r\n"
      "X-Content-Type-Options: nosniff\r\nCross-Origin-Resource-Policy: same-origin\r\n"
      "Cache-Control: no-store\r\n{}Connection: close\r\n\r\n",
      status.code, status.reason, size, status.code == 405 ? "Allow: GET, HEAD\r\n" : "");
}

}  // namespace palpate::app
