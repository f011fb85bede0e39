// SPDX-License-Identifier: Apache-2.0
#include "csv_header.hpp"

#include <algorithm>

#include "palpate/core/csv.hpp"

namespace palpate::app {

std::string_view csv_header(std::string_view text) {
  text = without_byte_order_mark(text);
  while (!text.empty()) {
    const auto end = std::min(text.find('\n'), text.size());
    const std::string_view line = trimmed(text.substr(0, end));
    if (!line.empty()) return line;
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return "";
}

}  // namespace palpate::app
