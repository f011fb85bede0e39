// SPDX-License-Identifier: Apache-2.0
#include "search_outcomes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>

#include "palpate/core/statistics.hpp"
#include "palpate/localization/localizer.hpp"
#include "processor_time.hpp"

namespace palpate::experiment {
namespace {

using namespace localization;

constexpr double kSure = 0.9;

template <class Value>
double mean_of(const SearchOutcomes& outcomes, Value value) {
  double sum = 0;
  for (const SearchOutcome& outcome : outcomes)
    sum += static_cast<double>(std::invoke(value, outcome));
  return outcomes.empty() ? 0 : sum / static_cast<double>(outcomes.size());
}

/// Mean distance of the stated probability from the share right, over ten bins of equal numbers.
double calibration_error(SearchOutcomes outcomes) {
  constexpr std::ptrdiff_t kBins = 10;
  std::ranges::stable_sort(outcomes, {}, &SearchOutcome::stated);
  const auto count = std::ssize(outcomes);
  double error = 0;
  for (std::ptrdiff_t bin = 0; bin < kBins; ++bin) {
    const SearchOutcomes part(outcomes.begin() + count * bin / kBins,
                              outcomes.begin() + count * (bin + 1) / kBins);
    error += static_cast<double>(part.size()) *
             std::abs(mean_of(part, &SearchOutcome::stated) - mean_of(part, &SearchOutcome::right));
  }
  return count == 0 ? 0 : error / static_cast<double>(count);
}

std::string rate(const SearchOutcomes& outcomes, bool SearchOutcome::*member) {
  const auto count = static_cast<std::size_t>(std::ranges::count(outcomes, true, member));
  const Interval interval = wilson_interval(count, outcomes.size());
  return fmt::format("{:.3f} [{:.2f}, {:.2f}]", mean_of(outcomes, member), interval.low,
                     interval.high);
}

}  // namespace

SearchSubject::SearchSubject(std::string its_name, std::uint64_t seed, int its_scenes)
    : name(std::move(its_name)),
      model(geometry::load_known_object(name)),
      mesh(model.object().mesh),
      first_seed(seed),
      scenes(its_scenes) {}

SearchSubjects generated_subjects(const Options& options, int shapes, int scenes) {
  SearchSubjects subjects;
  for (int i = 0; i < shapes; ++i) {
    const std::uint64_t seed = options.seed + static_cast<std::uint64_t>(i);
    subjects.push_back(
        std::make_unique<SearchSubject>(fmt::format("generated:{}", seed), seed, scenes));
  }
  return subjects;
}

SearchSubjects scanned_subjects(const Options& options, int scenes) {
  SearchSubjects subjects;
  const char* const data = std::getenv("PALPATE_DATA");
  if (options.quick || !data) {
    fmt::print("without scans: PALPATE_DATA names no folder, or --quick\n");
    return subjects;
  }
  for (const auto& entry :
       std::filesystem::directory_iterator(std::filesystem::path(data) / "ycb")) {
    if (entry.path().extension() != ".ply") continue;
    subjects.push_back(
        std::make_unique<SearchSubject>(entry.path().string(), options.seed, scenes));
  }
  std::ranges::sort(subjects, {}, [](const auto& subject) { return subject->name; });
  return subjects;
}

std::string_view to_string(SearchMethod method) {
  return method == SearchMethod::fast ? "fast" : "full";
}

SearchOutcome search_pose(const SearchSubject& subject, const Evidence& evidence,
                          const Eigen::Isometry3d& truth, SearchMethod method,
                          const RandomStream& random) {
  SearchOutcome outcome;
  const double start = processor_seconds();
  const Posterior posterior = method == SearchMethod::fast
                                  ? localize_fast(subject.model, evidence, random)
                                  : localize(subject.model, evidence, random);
  outcome.seconds = processor_seconds() - start;
  outcome.no_pose = posterior.modes.empty();
  if (outcome.no_pose) return outcome;
  const auto& symmetries = subject.model.object().symmetries;
  const Mode& best = posterior.modes.front();
  outcome.stated = pose_probability(best);
  outcome.right = within(pose_error(best.T_frame_object, truth, symmetries));
  outcome.covered = truth_in_credible_set(posterior, truth, symmetries);
  outcome.set_mass = posterior.credible_mass;
  outcome.certain = posterior.status == PoseStatus::certain;
  return outcome;
}

std::vector<std::string> search_columns(std::vector<std::string> names) {
  for (const char* column :
       {"scenes", "right", "stated", "stated > 0.9, wrong", "certain", "no pose",
        "truth in the 95 % set", "its stated mass", "calibration", "ms: median, 90 %, most"}) {
    names.emplace_back(column);
  }
  return names;
}

std::vector<std::string> search_row(std::vector<std::string> names,
                                    const SearchOutcomes& outcomes) {
  std::vector<double> ms;
  for (const SearchOutcome& outcome : outcomes) ms.push_back(1e3 * outcome.seconds);
  const auto sure_and_wrong = std::ranges::count_if(
      outcomes, [](const SearchOutcome& o) { return o.stated > kSure && !o.right; });
  for (const std::string& cell :
       {std::to_string(outcomes.size()), rate(outcomes, &SearchOutcome::right),
        fmt::format("{:.3f}", mean_of(outcomes, &SearchOutcome::stated)),
        std::to_string(sure_and_wrong),
        fmt::format("{:.3f}", mean_of(outcomes, &SearchOutcome::certain)),
        fmt::format("{:.3f}", mean_of(outcomes, &SearchOutcome::no_pose)),
        rate(outcomes, &SearchOutcome::covered),
        fmt::format("{:.3f}", mean_of(outcomes, &SearchOutcome::set_mass)),
        fmt::format("{:.3f}", calibration_error(outcomes)),
        fmt::format("{:.0f}, {:.0f}, {:.0f}", median(ms), quantile(ms, 0.9), quantile(ms, 1))}) {
    names.push_back(cell);
  }
  return names;
}

}  // namespace palpate::experiment
