// SPDX-License-Identifier: Apache-2.0
#include "palpate/localization/identification.hpp"

#include <fmt/format.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "evidence.hpp"
#include "html.hpp"
#include "localization_fields.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/option_check.hpp"
#include "palpate/localization/sizes.hpp"
#include "without_gil.hpp"

namespace palpate::python {
namespace {

namespace lo = localization;
using namespace nb::literals;

/// Which of several objects was touched, and the pose of each.
struct Identification {
  lo::ObjectProbabilities objects;
  std::vector<Posterior> posteriors;  ///< weights times the object's probability

  [[nodiscard]] bool explained() const { return objects.candidates.at(objects.best) > 0; }

  /// Of the most probable shape, in any size.
  [[nodiscard]] Posterior posterior() const {
    std::vector<lo::Posterior> found;
    for (const Posterior& one : posteriors) found.push_back(one.found);
    return {lo::pooled(candidates_of(posteriors), objects, found), posteriors[objects.best].model};
  }

  static lo::SizedCandidates candidates_of(const std::vector<Posterior>& posteriors) {
    lo::SizedCandidates candidates;
    for (const Posterior& one : posteriors) candidates.push_back(&one.model->object());
    return candidates;
  }
};

}  // namespace

template <>
struct Fields<lo::ObjectProbabilities> {
  static auto of(lo::ObjectProbabilities& it) {
    return std::tie(it.candidates, it.other, it.best, it.probability, it.size);
  }
};
template <>
struct Fields<Identification> {
  static auto of(Identification& it) { return std::tie(it.objects, it.posteriors); }
  static void check(const Identification& it) {
    const std::size_t count = it.posteriors.size();
    if (it.objects.candidates.size() == count && it.objects.best < count) return;
    throw BadInput(fmt::format("object {} of {}, with {} probabilities", it.objects.best, count,
                               it.objects.candidates.size()));
  }
};

namespace {

std::vector<SharedModel> models_from(const nb::sequence& models) {
  std::vector<SharedModel> shared;
  for (const nb::handle model : models) shared.push_back(model_from(nb::borrow(model)));
  if (shared.empty()) throw BadInput("models: 0 objects to choose from");
  return shared;
}

double mean_area(const std::vector<SharedModel>& models) {
  double sum = 0;
  for (const auto& model : models) sum += model->area();
  return sum / static_cast<double>(models.size());
}

/// @throws what a signal handler raised, as Ctrl-C does
void check_signals() {
  const WithGil acquire;
  if (PyErr_CheckSignals() != 0) throw nb::python_error();
}

Identification search(const std::vector<SharedModel>& models, const lo::Evidence& evidence,
                      const lo::IdentificationOptions& options, std::uint64_t seed) {
  std::vector<lo::ObjectHypothesis> hypotheses;
  for (const auto& model : models) {
    check_signals();
    hypotheses.push_back(
        lo::hypothesis_of(*model, evidence, RandomStream(seed, "localize"), {}, options));
  }
  Identification result{lo::object_probabilities(hypotheses, options), {}};
  for (std::size_t i = 0; i < models.size(); ++i) {
    result.posteriors.push_back(
        {lo::weighted(std::move(hypotheses[i].posterior), result.objects.candidates[i]),
         models[i]});
  }
  lo::choose_shape(Identification::candidates_of(result.posteriors), result.objects);
  return result;
}

Identification identify(const nb::sequence& models, const Contacts& contacts,
                        std::optional<lo::TableSupport> table, nb::object free_space,
                        nb::object planes, double other, double false_contacts,
                        double noise_scale_prior, double size_prior, double surface_sigma,
                        std::uint64_t seed) {
  const std::vector<SharedModel> shared = models_from(models);
  lo::Evidence evidence =
      evidence_from(contacts, {std::move(table), free_space, planes, false_contacts,
                               noise_scale_prior, size_prior, surface_sigma});
  evidence.contact_area = mean_area(shared);
  lo::IdentificationOptions options;
  options.other = other;
  options = checked(options);
  const WithoutGil release;
  return search(shared, evidence, options, seed);
}

std::string repr(const Identification& self) {
  if (!self.explained()) return "Identification(no pose of any object explains the contacts)";
  return fmt::format("Identification('{}', probability {:.3f}, none of the {} {:.3f})",
                     self.posteriors[self.objects.best].model->object().name,
                     self.objects.probability, self.posteriors.size(), self.objects.other);
}

std::string html(const Identification& self) {
  std::string rows;
  for (std::size_t i = 0; i < self.posteriors.size(); ++i) {
    rows +=
        fmt::format("<tr><td>{}</td><td>{:.3f}</td></tr>",
                    escaped(self.posteriors[i].model->object().name), self.objects.candidates[i]);
  }
  return fmt::format(
      "<div><table><tr><th>object</th><th>probability</th></tr>{}<tr><td>none of them</td>"
      "<td>{:.3f}</td></tr></table>{}</div>",
      rows, self.objects.other, posterior_html(self.posterior()));
}

void bind_result(nb::module_& module) {
  nb::class_<Identification> bound(module, "Identification",
                                   "Which of several objects was touched, and its pose.");
  bind_pickle(bound);
  bound
      .def_prop_ro(
          "probabilities", [](const Identification& self) { return self.objects.candidates; },
          "That it is each object, in the order of the models; with `other` they sum to 1, or are "
          "0 where "
          "no pose of any explains the contacts.")
      .def_prop_ro(
          "other", [](const Identification& self) { return self.objects.other; },
          "Probability that it is none of them.")
      .def_prop_ro(
          "best",
          [](const Identification& self) -> std::optional<std::size_t> {
            if (!self.explained()) return std::nullopt;
            return self.objects.best;
          },
          "Index of the most probable object (of the most probable size, if some are one object "
          "resized); None where no pose of any explains the contacts.")
      .def_prop_ro(
          "size", [](const Identification& self) { return self.objects.size; },
          "Of that object, relative to its mesh, on average over the sizes given.")
      .def_prop_ro("posterior", &Identification::posterior,
                   "Of the most probable object, in any size; its weights are times the object's "
                   "probability.")
      .def_ro("posteriors", &Identification::posteriors,
              "Of each object, their weights times the object's probability.")
      .def("__repr__", &repr)
      .def("_repr_html_", &html);
}

}  // namespace

void bind_identification(nb::module_& module) {
  bind_result(module);
  const lo::Evidence evidence;
  module.def(
      "identify", &identify, "models"_a, "contacts"_a, nb::kw_only(), "table"_a = nb::none(),
      "free_space"_a = nb::none(), "planes"_a = nb::none(),
      "other"_a = lo::IdentificationOptions().other,
      "false_contacts"_a = evidence.false_contact_share,
      "noise_scale_prior"_a = evidence.noise_scale_prior, "size_prior"_a = evidence.size_prior,
      "surface_sigma"_a = evidence.surface_sigma, "seed"_a = 0,
      nb::sig("def identify(models: collections.abc.Sequence[ObjectModel], contacts: Contacts, *, "
              "table: TableSupport | None = None, free_space: numpy.typing.ArrayLike | None = "
              "None, planes: numpy.typing.ArrayLike | None = None, other: float = 0.05, "
              "false_contacts: float = 0.02, noise_scale_prior: float = "
              "0.4, size_prior: float = 0.25, surface_sigma: float = 0.0003, seed: int = 0) -> "
              "Identification"),
      "Which of several objects the contacts are of, equally probable before, and its pose, by "
      "marginal likelihoods (Robert & Casella 2004, ch. 3).\n\nother: prior probability of an "
      "object that is none of them. free_space (N, 4), planes and the rest are those of "
      "localize(), whose "
      "method 'full' searches each object. Ctrl-C ends it after the object at hand.\n\nRaises "
      "ValueError as localize(), and for no "
      "models; TypeError for what is no ObjectModel.");
}

}  // namespace palpate::python
