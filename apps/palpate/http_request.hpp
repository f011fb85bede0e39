// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace palpate::app {

/// What a page server looks at of a request.
struct HttpRequest {
  bool well_formed = false;
  std::string_view method, target;
  std::optional<std::string_view> host, origin;
};

struct HttpStatus {
  int code;
  std::string_view reason;
};

/// Reads the head of a request, whole with its empty line; views into it.
HttpRequest parse_request(std::string_view head);

/// How a server of the one page "/" on the loopback port answers: 200 for a GET or HEAD of it that
/// names the server as its Host and, if any, as its Origin.
HttpStatus status_of(const HttpRequest& request, int port);

/// The head of an answer. @param size  bytes of its body
std::string answer_head(HttpStatus status, std::size_t size);

}  // namespace palpate::app
