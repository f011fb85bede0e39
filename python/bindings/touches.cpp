// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "arrays.hpp"
#include "libraries.hpp"
#include "palpate/core/error.hpp"
#include "palpate/localization/information/next_touch.hpp"
#include "pickle.hpp"
#include "without_gil.hpp"

namespace palpate::python {
namespace {

void check_positive(const char* what, double value) {
  if (value > 0 && std::isfinite(value)) return;
  throw BadInput(fmt::format("{} is {}, not positive", what, value));
}

}  // namespace

template <>
struct Fields<localization::TouchAction> {
  static auto of(localization::TouchAction& it) {
    return std::tie(it.start, it.direction, it.reach, it.seconds);
  }
  static void check(const localization::TouchAction& it) {
    if (!it.start.allFinite()) throw BadInput("start is not finite");
    if (!(std::abs(it.direction.norm() - 1) < 1e-6)) throw BadInput("direction has no direction");
    check_positive("reach", it.reach);
    check_positive("seconds", it.seconds);
  }
};
template <>
struct Fields<localization::PredictedTouch> {
  static auto of(localization::PredictedTouch& it) {
    return std::tie(it.hit, it.distance, it.normal);
  }
};

namespace {

namespace lo = localization;
using namespace nb::literals;

lo::TouchAction make_action(nb::object start, nb::object direction, double reach, double seconds) {
  const lo::TouchAction action{vector_from(start, "start"),
                               vector_from(direction, "direction").normalized(), reach, seconds};
  Fields<lo::TouchAction>::check(action);
  return action;
}

}  // namespace

void bind_touches(nb::module_& module) {
  using Action = lo::TouchAction;
  nb::class_<Action> bound(module, "TouchAction",
                           "A touch that could be made: a ball comes straight from its start until "
                           "it meets the object or has gone its reach.");
  bind_pickle(bound);
  bound
      .def(
          "__init__",
          [](Action* self, nb::object start, nb::object direction, double reach, double seconds) {
            new (self) Action(make_action(start, direction, reach, seconds));
          },
          "start"_a, "direction"_a, nb::kw_only(), "reach"_a = 0.3, "seconds"_a = 1.0,
          nb::sig("def __init__(self, start: numpy.typing.ArrayLike, direction: "
                  "numpy.typing.ArrayLike, *, reach: float = 0.3, seconds: float = 1.0) -> None"),
          "start (3,): of the ball's centre, m; direction (3,), any length; reach, m; seconds: "
          "what it costs.\n\nRaises ValueError for other shapes, no direction, and numbers that "
          "are not positive.")
      .def_ro("start", &Action::start, nb::rv_policy::copy, "(3,), m.")
      .def_ro("direction", &Action::direction, nb::rv_policy::copy, "(3,), unit.")
      .def_ro("reach", &Action::reach, "m.")
      .def_ro("seconds", &Action::seconds, "s.")
      .def("__repr__", [](const Action& self) {
        return fmt::format(
            "TouchAction(from ({:.3f}, {:.3f}, {:.3f}) m along ({:.2f}, {:.2f}, "
            "{:.2f}), {:.3f} m)",
            self.start.x(), self.start.y(), self.start.z(), self.direction.x(), self.direction.y(),
            self.direction.z(), self.reach);
      });
  using Predicted = lo::PredictedTouch;
  nb::class_<Predicted> predicted(module, "PredictedTouch", "How a touch ends at a pose.");
  bind_pickle(predicted);
  predicted.def_ro("hit", &Predicted::hit, "Whether the ball meets the object.")
      .def_ro("distance", &Predicted::distance, "Gone by the ball, m.")
      .def_ro("normal", &Predicted::normal, nb::rv_policy::copy,
              "Of the object there, (3,); zero after a miss.")
      .def("__repr__", [](const Predicted& self) {
        return self.hit ? fmt::format("PredictedTouch(hit after {:.1f} mm)", 1e3 * self.distance)
                        : std::string("PredictedTouch(miss)");
      });
  module.def(
      "predict_touch",
      [](const geometry::ObjectModel& model, nb::object T, const Action& action,
         double tip_radius) {
        check_positive("tip_radius", tip_radius);
        return lo::predict_touch(model, pose_from(T, "T_frame_object"), action, tip_radius);
      },
      "model"_a, "T_frame_object"_a, "action"_a, nb::kw_only(), "tip_radius"_a = 0.0075,
      nb::sig("def predict_touch(model: ObjectModel, T_frame_object: "
              "numpy.typing.ArrayLike, action: TouchAction, *, tip_radius: float = 0.0075) "
              "-> PredictedTouch"),
      "Where a ball of tip_radius (m) meets the object at a pose (4, 4).\n\nRaises "
      "ValueError unless it is a pose and the radius positive.");
  module.def(
      "choose_touch",
      [](const geometry::ObjectModel& model, const Posterior& posterior,
         const std::vector<Action>& actions, double tip_radius, std::uint64_t seed) {
        check_positive("tip_radius", tip_radius);
        require_same_object(posterior, model);
        lo::NextTouchOptions options;
        options.tip_radius = tip_radius;
        const auto choice = lo::choose_touch(model, posterior.found, actions,
                                             RandomStream(seed, "next touch"), options);
        return std::pair{choice.index, choice.information};
      },
      "model"_a, "posterior"_a, "actions"_a, nb::kw_only(), "tip_radius"_a = 0.0075, "seed"_a = 0,
      nb::call_guard<WithoutGil>(),
      "Index of the touch with the largest expected information gain about the pose per second, "
      "and "
      "a lower bound of that gain, nats (Kolchinsky & Tracey 2017).\n\nRaises ValueError "
      "for no touches, and for a posterior without modes or of another object.");
}

}  // namespace palpate::python
