// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "palpate/recording/replay_page.hpp"
#include "recording/html.hpp"

namespace palpate::recording {
namespace {

constexpr std::string_view kPage = R"(<!doctype html>
<!-- SPDX-License-Identifier: Apache-2.0 -->
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; media-src blob:; frame-src 'self' about:">
<title>{}</title>
<style>
  html, body {{ height: 100%; margin: 0; }}
  body {{ display: grid; grid-template: minmax(0, 1fr) / 1fr 1fr; gap: 2px; }}
  @media (max-width: 860px) {{ body {{ grid-template: repeat(2, minmax(0, 1fr)) / 1fr; }} }}
  iframe {{ border: 0; width: 100%; height: 100%; }}
</style>
</head>
<body>
<iframe title="left" srcdoc="{}"></iframe>
<iframe title="right" srcdoc="{}"></iframe>
<script>
// What one of the two does, the other does as well.
const frames = [...document.querySelectorAll('iframe')];
addEventListener('message', (event) => {{
  for (const frame of frames) {{
    if (frame.contentWindow !== event.source) frame.contentWindow.postMessage(event.data, '*');
  }}
}});
// Until one of them is clicked, keys are for the left one.
addEventListener('keydown', (event) => {{
  const {{key, shiftKey, ctrlKey, metaKey, altKey}} = event;
  const same = new KeyboardEvent('keydown', {{key, shiftKey, ctrlKey, metaKey, altKey, cancelable: true}});
  if (!frames[0].contentDocument.dispatchEvent(same)) event.preventDefault();
}});
</script>
</body>
</html>
)";

}  // namespace

std::string compare_page(std::string_view left, std::string_view right, std::string_view title) {
  return fmt::format(fmt::runtime(kPage), escaped_html(title), escaped_html(left),
                     escaped_html(right));
}

}  // namespace palpate::recording
