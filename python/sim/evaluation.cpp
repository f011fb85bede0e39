// SPDX-License-Identifier: Apache-2.0
#include "palpate/evaluation/evaluation.hpp"

#include <fmt/format.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <numeric>
#include <stdexcept>
#include <string>

#include "bindings/arrays.hpp"
#include "bindings/pickle.hpp"
#include "interruptible.hpp"
#include "libraries.hpp"
#include "palpate/core/error.hpp"

namespace palpate::python {

template <>
struct Fields<evaluation::ObjectSummary> {  // what Python cannot see is left out
  static auto of(evaluation::ObjectSummary& it) {
    return std::tie(it.trials, it.lifted, it.pose_ok, it.pose_tight, it.covered, it.confident_wrong,
                    it.robot_seconds, it.probability, it.rotation_error_deg,
                    it.translation_error_mm, it.failures);
  }
};

namespace {

using namespace nb::literals;
using evaluation::ObjectSummary;

ObjectSummary evaluate(nb::object object, const std::string& hand, int trials, std::uint64_t seed,
                       int threads, const nb::dict& settings) {
  if (trials < 1) throw BadInput(fmt::format("trials must be at least 1, not {}", trials));
  if (threads < 1) throw BadInput(fmt::format("threads must be at least 1, not {}", threads));
  evaluation::TrialOptions options = trial_options(settings);
  options.world.hand = hand;
  const SharedModel model = object_from(std::move(object));
  return interruptible([&](const std::stop_token& stop) {
    ObjectSummary result;
    const auto numbers = evaluation::trial_numbers(static_cast<std::size_t>(trials));
    evaluation::EvaluationHooks hooks;
    hooks.trial = [&](evaluation::TrialId, const evaluation::Trial&) {
      if (stop.stop_requested()) throw std::runtime_error("stopped");
    };
    hooks.object = [&](std::size_t, const ObjectSummary& summary) { result = summary; };
    evaluation::evaluate({{&model->object(), numbers, &*model}}, options, seed, threads, hooks);
    return result;
  });
}

double mean_probability(const ObjectSummary& summary) {
  const auto& values = summary.probability;
  return std::accumulate(values.begin(), values.end(), 0.0) /
         std::max(1.0, static_cast<double>(values.size()));
}

}  // namespace

void bind_evaluation(nb::module_& module) {
  nb::class_<ObjectSummary> bound(
      module, "EvaluationResult",
      "What became of an object's trials; counts are of all trials started.");
  bind_pickle(bound);
  bound.def_ro("trials", &ObjectSummary::trials, "Started.")
      .def_ro("lifted", &ObjectSummary::lifted,
              "5 cm above the table for the whole hold, slipped less than 10 mm.")
      .def_ro("pose_ok", &ObjectSummary::pose_ok,
              "Lifted, and the best pose within 5 deg and 10 mm, modulo symmetry.")
      .def_ro("pose_tight", &ObjectSummary::pose_tight, "The same, 2.5 deg and 3.5 mm.")
      .def_ro("coverage", &ObjectSummary::covered, "Lifted, and the truth in the stated set.")
      .def_ro("confident_wrong", &ObjectSummary::confident_wrong,
              "The best pose wrong, with a probability above 0.9.")
      .def_prop_ro("mean_probability", &mean_probability,
                   "Of the best pose, over lifted trials with one.")
      .def_ro("robot_seconds", &ObjectSummary::robot_seconds, "Of each trial, s.")
      .def_ro("rotation_error_deg", &ObjectSummary::rotation_error_deg,
              "Of each lifted trial with a pose, deg.")
      .def_ro("translation_error_mm", &ObjectSummary::translation_error_mm, "The same, mm.")
      .def_ro("failures", &ObjectSummary::failures, "How many failed in which phase.")
      .def("__repr__", [](const ObjectSummary& self) {
        return fmt::format(
            "EvaluationResult({} trials, {} lifted, {} right, {} confident and wrong)", self.trials,
            self.lifted, self.pose_ok, self.confident_wrong);
      });
  module.def(
      "evaluate", &evaluate, "object"_a = "mug", "hand"_a = "shadow", nb::kw_only(),
      "trials"_a = 10, "seed"_a = 0, "threads"_a = 1, "options"_a = nb::dict(),
      nb::sig(
          "def evaluate(object: str | os.PathLike | palpate._core.ObjectModel = 'mug', hand: "
          "str = 'shadow', "
          "*, trials: int = 10, seed: int = 0, threads: int = 1, options: dict[str, typing.Any] "
          "= {}) -> EvaluationResult"),
      "Repeats the simulated pick with the seeds seed, seed + 1, ..., and scores it by the truth; "
      "the same for any number of threads.\n\nRaises ValueError for what there is not, and values "
      "out of their range.");
}

}  // namespace palpate::python
