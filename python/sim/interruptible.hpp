// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nanobind/nanobind.h>

#include <chrono>
#include <future>
#include <optional>
#include <stop_token>

#include "bindings/without_gil.hpp"

namespace palpate::python {

/// work(stop token) in a thread of its own and without the GIL, while Ctrl-C is looked for: that
/// requests a stop, and is raised when the work has ended.
template <class Work>
auto interruptible(const Work& work) {
  constexpr std::chrono::milliseconds kLook(100);
  std::stop_source stop;
  std::optional<nanobind::python_error> caught;
  auto running = std::async(std::launch::async, [&] { return work(stop.get_token()); });
  {
    const WithoutGil release;
    while (running.wait_for(kLook) != std::future_status::ready) {
      const WithGil acquire;
      if (PyErr_CheckSignals() == 0) continue;
      caught.emplace();
      stop.request_stop();
    }
  }
  if (caught) throw *caught;
  return running.get();
}

}  // namespace palpate::python
