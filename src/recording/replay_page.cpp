// SPDX-License-Identifier: Apache-2.0
#include "palpate/recording/replay_page.hpp"

#include <fmt/format.h>

#include "palpate/core/error.hpp"
#include "palpate/recording/page_stream.hpp"
#include "recording/html.hpp"
#include "recording/page_data.hpp"

namespace palpate::recording {
namespace {

std::string replaced(std::string_view text, std::string_view what, std::string_view by) {
  std::string result;
  for (std::size_t at; (at = text.find(what)) != text.npos; text.remove_prefix(at + what.size())) {
    result.append(text.substr(0, at)).append(by);
  }
  return result.append(text);
}

/// What comes before the mark; `page` is left with what comes after it.
std::string_view cut_at(std::string_view mark, std::string_view& page) {
  const auto at = page.find(mark);
  if (at == page.npos) throw BadInput(fmt::format("the replay page's template lacks {}", mark));
  const auto before = page.substr(0, at);
  page.remove_prefix(at + mark.size());
  return before;
}

std::string page_of(const nlohmann::json& content, std::string_view page, std::string_view script,
                    std::string_view title) {
  const auto data = content.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  // Cut before anything is filled in, so that a mark inside a name or the script means nothing.
  const auto before_title = cut_at("{{title}}", page);
  const auto before_recording = cut_at("{{recording}}", page);
  const auto before_script = cut_at("{{script}}", page);
  // Neither may hold a closing script tag: a browser ends the element there whatever the language.
  return fmt::format("{}{}{}{}{}{}{}", before_title, escaped_html(title), before_recording,
                     replaced(data, "<", "\\u003c"), before_script,
                     replaced(script, "</script", "<\\/script"), page);
}

}  // namespace

std::string replay_page(const Recording& recording, const hand::HandVisuals& visuals,
                        std::string_view page, std::string_view script, std::string_view title) {
  return page_of(page_data(recording, visuals), page, script, title);
}

std::string live_page(const RecordingHeader& header, const hand::HandVisuals& visuals,
                      std::string_view page, std::string_view script, std::string_view title) {
  Recording nothing_yet;
  nothing_yet.header = header;
  auto data = page_data(nothing_yet, visuals);
  data["live"] = true;
  return page_of(data, page, script, title);
}

}  // namespace palpate::recording
