// SPDX-License-Identifier: Apache-2.0
#include "pick_result.hpp"

#include <fmt/format.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <array>
#include <string_view>
#include <utility>

#include "bindings/arrays.hpp"
#include "bindings/html.hpp"
#include "bindings/libraries.hpp"
#include "palpate/core/angle.hpp"
#include "pick_fields.hpp"

namespace palpate::python {
namespace {

using skills::PhaseReport;

std::string_view status(const PickResult& result) {
  if (result.picked.fault) return "fault";
  return result.picked.held ? "held" : "failed";
}

Posterior posterior(const PickResult& result) {
  return {result.picked.estimate.posterior, result.model};
}

nb::object state(const PickResult& result) {
  return nb::make_tuple(Kept<PickResult>::of(result), posterior(result));
}

void restore(PickResult* self, const std::tuple<nb::object, Posterior>& state) {
  auto result = restored<PickResult>(std::get<0>(state));
  result.picked.estimate.posterior = std::get<1>(state).found;
  result.model = std::get<1>(state).model;
  new (self) PickResult(std::move(result));
}

std::string row(const PhaseReport& phase) {
  return fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td><td>{:.1f}</td></tr>",
                     escaped(phase.name), skills::to_string(phase.status), escaped(phase.outcome),
                     phase.robot_seconds);
}

void bind_phase(nb::module_& module) {
  nb::class_<PhaseReport> bound(module, "PhaseReport", "What became of a phase.");
  bind_pickle(bound);
  bound.def_ro("name", &PhaseReport::name, "Of the phase.")
      .def_prop_ro(
          "status",
          [](const PhaseReport& self) { return std::string(skills::to_string(self.status)); },
          "'ok', 'failed', 'timed_out' or 'fault'.")
      .def_ro("outcome", &PhaseReport::outcome, "In words.")
      .def_ro("robot_seconds", &PhaseReport::robot_seconds, "s.")
      .def_ro("wall_seconds", &PhaseReport::wall_seconds, "s.")
      .def_ro("contacts", &PhaseReport::contacts, "Of fingertips, at its end.")
      .def_ro("peak_force", &PhaseReport::peak_force, "Largest of a fingertip contact, N.")
      .def("__repr__", [](const PhaseReport& self) {
        return fmt::format("PhaseReport({}, {}: {}; {:.1f} s)", self.name,
                           skills::to_string(self.status), self.outcome, self.robot_seconds);
      });
}

/// An exception knows the frames that it passed, and these may know the result: Python's collector
/// has to see through it.
int traverse(PyObject* self, visitproc visit, void* arg) {
  Py_VISIT(Py_TYPE(self));
  if (nb::inst_ready(self)) Py_VISIT(nb::inst_ptr<PickResult>(self)->raised.ptr());
  return 0;
}
int clear(PyObject* self) {
  nb::inst_ptr<PickResult>(self)->raised.reset();
  return 0;
}
const std::array<PyType_Slot, 3> kSlots = {{{Py_tp_traverse, reinterpret_cast<void*>(traverse)},
                                            {Py_tp_clear, reinterpret_cast<void*>(clear)},
                                            {0, nullptr}}};

/// @param of  what of the metrics, where they are known and there is a pose
template <class Of>
auto with_truth(const Of& of) {
  return [of](const PickResult& self) -> std::optional<decltype(of(*self.metrics))> {
    if (!self.metrics || !self.metrics->has_pose) return std::nullopt;
    return of(*self.metrics);
  };
}

}  // namespace

std::string repr(const PickResult& result) {
  const auto& picked = result.picked;
  const std::string attempts =
      fmt::format("{} attempt{}", picked.attempts, picked.attempts == 1 ? "" : "s");
  if (picked.fault) {
    return fmt::format("PickResult(fault {}: {})", skills::to_string(picked.fault.fault),
                       picked.fault.detail);
  }
  if (!picked.held) {
    return fmt::format("PickResult(failed in {}, {}, {:.1f} s)", picked.failed_phase, attempts,
                       result.robot_seconds);
  }
  return fmt::format(
      "PickResult(held, {}, probability {:.3f}, {:.1f} s{})", attempts,
      localization::best_probability(picked.estimate.posterior), result.robot_seconds,
      result.place ? fmt::format(", {}", skills::to_string(result.place->status)) : "");
}

std::string html(const PickResult& result) {
  std::string rows;
  for (const PhaseReport& phase : result.picked.phases) rows += row(phase);
  return fmt::format(
      "<div><b>{}</b><table><tr><th>phase</th><th>status</th><th>outcome</th><th>s</th></tr>{}"
      "</table>{}</div>",
      escaped(repr(result)), rows,
      nb::cast<std::string>(nb::cast(posterior(result)).attr("_repr_html_")()));
}

void bind_pick_result(nb::module_& module) {
  bind_phase(module);
  bind_place_result(module);
  nb::class_<PickResult>(module, "PickResult", nb::type_slots(kSlots.data()),
                         "Result of a pick, as the robot estimates it; fields that need the "
                         "simulator's true pose are None for a hand of your own.")
      .def_prop_ro(
          "status", [](const PickResult& self) { return std::string(status(self)); },
          "'held', 'failed' or 'fault'.")
      .def_prop_ro(
          "held", [](const PickResult& self) { return self.picked.held; },
          "The object hangs in the hand.")
      .def_prop_ro(
          "attempts", [](const PickResult& self) { return self.picked.attempts; }, "Grasps.")
      .def_prop_ro(
          "failed_phase", [](const PickResult& self) { return self.picked.failed_phase; },
          "Of the last attempt; empty if all went well.")
      .def_prop_ro(
          "fault",
          [](const PickResult& self) {
            return std::string(skills::to_string(self.picked.fault.fault));
          },
          "That stopped the robot for good; 'none' without one.")
      .def_prop_ro(
          "fault_detail", [](const PickResult& self) { return self.picked.fault.detail; },
          "One line with the values.")
      .def_ro("exception", &PickResult::raised,
              nb::sig("def exception(self) -> BaseException | None"),
              "The first that the hand, the arm or a sensor raised.")
      .def_prop_ro(
          "phases", [](const PickResult& self) { return self.picked.phases; },
          "Reports, in the order of time.")
      .def_prop_ro(
          "events",
          [](const PickResult& self) {
            std::vector<std::pair<std::string, double>> events;
            for (const auto& [event, time] : self.events) {
              events.emplace_back(estimation::kTouchEventNames[static_cast<std::size_t>(event)],
                                  time);
            }
            return events;
          },
          "What the robot noted: name, and time in s.")
      .def_ro("robot_seconds", &PickResult::robot_seconds, "s, from start to end.")
      .def_prop_ro("posterior", &posterior,
                   nb::sig("def posterior(self) -> palpate._core.Posterior"),
                   "Of the pose in the world, at the end of the lift.")
      .def_prop_ro(
          "lifted",
          [](const PickResult& self) -> std::optional<bool> {
            if (!self.metrics) return std::nullopt;
            return self.metrics->lifted;
          },
          "In truth: 5 cm above the table for the whole hold, slipped less than 10 mm.")
      .def_prop_ro("pose_ok", with_truth([](const auto& metrics) { return metrics.pose_ok; }),
                   "In truth: within 5 deg and 10 mm, modulo symmetry.")
      .def_prop_ro("rotation_error_deg", with_truth([](const auto& metrics) {
                     return kDegreesPerRadian * metrics.error.rotation;
                   }),
                   "Of the best pose from the truth, modulo symmetry, deg.")
      .def_prop_ro("translation_error_mm",
                   with_truth([](const auto& metrics) { return 1e3 * metrics.error.translation; }),
                   "The same, mm.")
      .def_ro("place", &PickResult::place,
              "What became of placing; None where the object was not to be placed, or not held.")
      .def("__getstate__", &state)
      .def("__setstate__", &restore)
      .def("__repr__", &repr)
      .def("_repr_html_", &html);
}

}  // namespace palpate::python
