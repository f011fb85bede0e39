// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nanobind/nanobind.h>

#include <atomic>
#include <chrono>
#include <optional>
#include <thread>

namespace palpate::python {

/// What threads that come back to Python need to know of an interpreter that is about to end.
struct InterpreterEnd {
  std::atomic<bool> near = false;
  std::atomic<int> returning = 0;      ///< threads that wait for the GIL
  std::atomic<std::thread::id> ender;  ///< which may still take it
};
inline InterpreterEnd interpreter_end;

/// The time in which a thread waits for the GIL. A daemon thread that asks for it after the
/// interpreter began to end waits for the end of the process instead: before 3.14, CPython would
/// end such a thread by unwinding its stack, and C++ abort the process at that.
class ReturnToPython {
 public:
  ReturnToPython() {
    ++interpreter_end.returning;
    if (!interpreter_end.near || interpreter_end.ender.load() == std::this_thread::get_id()) return;
    --interpreter_end.returning;
    for (;;) std::this_thread::sleep_for(std::chrono::hours(1));
  }
  ReturnToPython(const ReturnToPython&) = delete;
  ReturnToPython& operator=(const ReturnToPython&) = delete;
  ~ReturnToPython() { --interpreter_end.returning; }
};

/// Does without the GIL for a scope.
class WithoutGil {
 public:
  WithoutGil() : state_(PyEval_SaveThread()) {}
  WithoutGil(const WithoutGil&) = delete;
  WithoutGil& operator=(const WithoutGil&) = delete;
  ~WithoutGil() {
    const ReturnToPython counted;
    PyEval_RestoreThread(state_);
  }

 private:
  PyThreadState* state_;
};

/// Holds the GIL for a scope, in any thread.
class WithGil {
 public:
  WithGil() {
    const ReturnToPython counted;
    held_.emplace();
  }

 private:
  std::optional<nanobind::gil_scoped_acquire> held_;
};

/// To be called as a module is imported: lets WithoutGil know when the interpreter ends. Threads
/// that already wait for the GIL get it before.
inline void watch_interpreter_end() {
  const auto end = [] {
    interpreter_end.ender = std::this_thread::get_id();
    interpreter_end.near = true;
    for (int i = 0; i < 200 && interpreter_end.returning > 0; ++i) {  // some are none after a fork
      const nanobind::gil_scoped_release release;                     // the others may have it
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  };
  nanobind::module_::import_("atexit").attr("register")(nanobind::cpp_function(end));
}

}  // namespace palpate::python
