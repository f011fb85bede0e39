// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace palpate::app {

/// What a page server looks at of a request.
struct HttpRequest {
  bool well_formed = false;
  std::string_view method, path, query;
  std::optional<std::string_view> host, origin, last_event_id;
};

struct HttpStatus {
  int code;
  std::string_view reason;
};

/// What a request is judged by.
struct ServerSide {
  std::string host = "127.0.0.1";
  int port = 0;
  std::string token;     ///< that a request must have; empty: it must name this machine as its host
  bool streams = false;  ///< "/events" is there
};

/// Reads the head of a request, whole with its empty line; views into it.
HttpRequest parse_request(std::string_view head);

/// How a server answers: 200 for a GET or HEAD of "/" or, if it streams, GET of "/events" that may
/// have it.
HttpStatus status_of(const HttpRequest& request, const ServerSide& side);

/// What a browser that lost a stream states as the last message that it has: "RUN-NUMBER".
std::string message_id(std::string_view run, std::uint64_t number);
/// Number of the message after which a stream of this run is to go on; none if it is of another.
std::optional<std::uint64_t> last_message(const HttpRequest& request, std::string_view run);

/// The head of an answer. @param size  bytes of its body
std::string answer_head(HttpStatus status, std::size_t size);
/// The head of a stream.
std::string stream_head();

/// 128 random bits in hexadecimal.
std::string random_token();

}  // namespace palpate::app
