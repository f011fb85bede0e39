// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "bindings/arrays.hpp"
#include "palpate/core/angle.hpp"
#include "pick_fields.hpp"
#include "pick_result.hpp"

namespace palpate::python {
namespace {

std::string text_of(const PlaceResult& result) {
  const std::string off = result.metrics
                              ? fmt::format(", {:.1f} deg and {:.1f} mm from the target",
                                            result.metrics->error.rotation * kDegreesPerRadian,
                                            1e3 * result.metrics->error.translation)
                              : "";
  return fmt::format("PlaceResult({} by {}{})", skills::to_string(result.status), result.strategy,
                     off);
}

/// @param of  what of the metrics, where they are known
template <class Of>
auto with_truth(const Of& of) {
  return [of](const PlaceResult& self) -> std::optional<decltype(of(*self.metrics))> {
    if (!self.metrics) return std::nullopt;
    return of(*self.metrics);
  };
}

}  // namespace

PlaceResult place_result(const skills::PlaceResult& placed, const skills::StrategyTaken& strategy,
                         const std::optional<evaluation::PlaceMetrics>& metrics) {
  return {placed.status,         placed.failed_phase,
          placed.phases,         std::string(skills::to_string(strategy.strategy)),
          strategy.reason,       placed.T_world_target,
          placed.T_world_placed, placed.certain,
          placed.upright,        metrics};
}

void bind_place_result(nb::module_& module) {
  nb::class_<PlaceResult> bound(
      module, "PlaceResult",
      "Result of placing, as the robot estimates it; fields that need the "
      "simulator's true pose are None for a hand of your own.");
  bind_pickle(bound);
  bound
      .def_prop_ro(
          "status",
          [](const PlaceResult& self) { return std::string(skills::to_string(self.status)); },
          "'placed'; 'ambiguous', 'unreachable', 'refused' or 'slipped' where the object was put "
          "back; 'lost', 'stuck', 'missing' or 'under_way'.")
      .def_ro("failed_phase", &PlaceResult::failed_phase, "Empty if all went well.")
      .def_ro("phases", &PlaceResult::phases, "Reports, in the order of time.")
      .def_ro("strategy", &PlaceResult::strategy,
              "By which the object was turned: 'wrist', 'fingers' or 'regrasp'.")
      .def_ro("reason", &PlaceResult::reason, "Of the strategy, in words.")
      .def_prop_ro(
          "T_world_target", [](const PlaceResult& self) { return pose(self.T_world_target); },
          "Where the object was to go, (4, 4), m.")
      .def_prop_ro(
          "T_world_placed",
          [](const PlaceResult& self) -> std::optional<Pose4> {
            if (!self.T_world_placed) return std::nullopt;
            return pose(*self.T_world_placed);
          },
          "Estimated pose at the release, (4, 4), m; None if it was not released.")
      .def_ro("certain", &PlaceResult::certain, "Expected within 5 deg and 10 mm of the target.")
      .def_ro("upright", &PlaceResult::upright,
              "Probability that it leans by less than 5 deg where it stands.")
      .def_prop_ro(
          "placed", with_truth([](const auto& metrics) { return metrics.placed; }),
          "By its true pose: released, and within 5 deg and 10 mm of the target at the end.")
      .def_prop_ro("dropped", with_truth([](const auto& metrics) { return metrics.dropped; }),
                   "By its true pose: it left the hand before the release.")
      .def_prop_ro("rotation_error_deg", with_truth([](const auto& metrics) {
                     return kDegreesPerRadian * metrics.error.rotation;
                   }),
                   "Of the object at the end from the target, modulo symmetry, deg.")
      .def_prop_ro("translation_error_mm",
                   with_truth([](const auto& metrics) { return 1e3 * metrics.error.translation; }),
                   "The same, mm.")
      .def("__repr__", [](const PlaceResult& self) { return text_of(self); });
}

}  // namespace palpate::python
