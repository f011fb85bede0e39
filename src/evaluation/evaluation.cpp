// SPDX-License-Identifier: Apache-2.0
#include "palpate/evaluation/evaluation.hpp"

#include <mutex>
#include <numeric>
#include <utility>

#include "palpate/core/angle.hpp"
#include "palpate/core/memory.hpp"
#include "palpate/core/parallel.hpp"
#include "palpate/core/statistics.hpp"

namespace palpate::evaluation {
namespace {

constexpr double kCertainObject = 0.95;

std::string failed_phase(const Trial& trial) {
  return trial.result.held ? "slip" : trial.result.failed_phase;
}

void add(const localization::PoseError& error, ErrorSummary& errors) {
  errors.rotation_deg.push_back(kDegreesPerRadian * error.rotation);
  errors.translation_mm.push_back(1e3 * error.translation);
}

void count_phases(const std::vector<skills::PhaseReport>& reports,
                  std::map<std::string, PhaseSummary>& phases) {
  for (const skills::PhaseReport& report : reports) {
    PhaseSummary& phase = phases[report.name];
    ++phase.runs;
    phase.ok += report.status == skills::PhaseStatus::ok;
    phase.robot_seconds.push_back(report.robot_seconds);
    phase.wall_seconds.push_back(report.wall_seconds);
  }
}

void count_place(const Trial& trial, PlaceSummary& summary) {
  if (!trial.place) return;
  const PlaceMetrics& metrics = trial.place_metrics;
  const bool certain = trial.place->certain && !trial.place->on_the_way;
  summary.certain += certain;
  summary.certain_placed += certain && metrics.placed;
  summary.certain_tight += certain && metrics.tight;
  summary.placed += metrics.placed;
  summary.tight += metrics.tight;
  summary.wrong += metrics.wrong;
  summary.dropped += metrics.dropped;
  summary.in_stable_pose += metrics.in_stable_pose;
  ++summary.status[std::string(skills::to_string(trial.place->status))];
  if (!trial.place->T_world_placed || trial.place->on_the_way) return;
  add(metrics.error, summary.final_error);
  add(metrics.estimate, summary.estimate_error);
  add(metrics.release, summary.release_motion);
}

/// An object's model, made when its first trial begins.
class Preparation {
 public:
  std::shared_ptr<const geometry::ObjectModel> begin(const EvaluatedObject& object) {
    const std::lock_guard lock(mutex_);
    if (!model_) {
      model_ = object.model
                   ? std::shared_ptr<const geometry::ObjectModel>(object.model, [](auto*) {})
                   : std::make_shared<const geometry::ObjectModel>(*object.known);
    }
    return model_;
  }

  void release() {
    const std::lock_guard lock(mutex_);
    model_.reset();
  }

 private:
  std::mutex mutex_;
  std::shared_ptr<const geometry::ObjectModel> model_;
};

/// Trials put together object after object.
class SummariesInOrder {
 public:
  SummariesInOrder(const std::vector<EvaluatedObject>& objects, const EvaluationHooks& hooks)
      : objects_(objects), hooks_(hooks) {}

  /// The object that the next trial may be of.
  [[nodiscard]] std::size_t next() const { return next_; }

  void add(const TrialId& id, const Trial& trial) {
    add_trial(trial, summary_);
    if (hooks_.trial) hooks_.trial(id, trial);
  }

  void end_object() {
    summary_.symmetry_order = objects_[next_].known->symmetries.size();
    const ObjectSummary ended = std::exchange(summary_, {});
    if (hooks_.object) hooks_.object(next_, ended);
    ++next_;
  }

 private:
  const std::vector<EvaluatedObject>& objects_;
  const EvaluationHooks& hooks_;
  ObjectSummary summary_;
  std::size_t next_ = 0;
};

}  // namespace

void add_trial(const Trial& trial, ObjectSummary& summary) {
  const TrialMetrics& metrics = trial.metrics;
  ++summary.trials;
  summary.robot_seconds.push_back(trial.robot_seconds);
  summary.confident_wrong += metrics.confident_wrong();
  count_phases(trial.result.phases, summary.phases);
  if (trial.place) count_phases(trial.place->phases, summary.phases);
  count_place(trial, summary.place);
  if (!metrics.lifted) {
    ++summary.failures[failed_phase(trial)];
    summary.false_hold += trial.result.held;
    return;
  }
  ++summary.lifted;
  summary.slip_mm.push_back(1e3 * metrics.slip);
  summary.lifted_at_once += trial.result.attempts == 1;
  summary.tip_force.push_back(metrics.tip_force);
  summary.explored_motion_mm.push_back(1e3 * metrics.explored_motion);
  if (!metrics.has_pose) {
    ++summary.failures["pose"];
    return;
  }
  summary.object_ok += metrics.object_ok;
  const bool sure_of_object = metrics.object_probability > kCertainObject;
  summary.object_certain += sure_of_object;
  summary.object_certain_ok += sure_of_object && metrics.object_ok;
  summary.pose_ok += metrics.pose_ok;
  summary.pose_tight += metrics.pose_tight;
  summary.pose_ok_before_lift += metrics.pose_ok_before_lift;
  summary.pose_ok_before_probe += metrics.pose_ok_before_probe;
  summary.pose_ok_tracked += metrics.pose_ok_tracked;
  summary.probed += metrics.probes > 0;
  summary.covered += metrics.covered;
  summary.certain += metrics.status == localization::PoseStatus::certain;
  summary.probability.push_back(metrics.probability);
  summary.rotation_error_deg.push_back(kDegreesPerRadian * metrics.error.rotation);
  summary.translation_error_mm.push_back(1e3 * metrics.error.translation);
  summary.modes.push_back(static_cast<double>(trial.result.estimate.posterior.modes.size()));
}

std::vector<std::size_t> trial_numbers(std::size_t count) {
  std::vector<std::size_t> numbers(count);
  std::iota(numbers.begin(), numbers.end(), std::size_t{0});
  return numbers;
}

void evaluate(const std::vector<EvaluatedObject>& objects, const TrialOptions& options,
              std::uint64_t first_seed, int threads, const EvaluationHooks& hooks,
              const estimation::Candidates& candidates) {
  std::vector<TrialId> trials;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    for (const std::size_t number : objects[i].numbers) trials.push_back({i, number});
  }
  std::vector<Preparation> preparations(objects.size());
  SummariesInOrder summaries(objects, hooks);
  const auto summarize = [&](const TrialId& id, const Trial& trial) {
    for (; summaries.next() < id.object; summaries.end_object()) {
      preparations[summaries.next()].release();
    }
    summaries.add(id, trial);
  };
  parallel_ordered(
      trials.size(), threads,
      [&](std::size_t i) {
        const TrialId& id = trials[i];
        auto known = hooks.finished ? hooks.finished(id) : std::nullopt;
        if (known) return std::move(*known);
        const auto model = preparations[id.object].begin(objects[id.object]);
        const auto believed = candidates.empty() ? estimation::Candidates{model.get()} : candidates;
        const auto sink = hooks.sink ? hooks.sink(id) : nullptr;
        Trial trial = run_trial(*model, believed, options, first_seed + id.number, sink.get());
        return_free_memory();
        return trial;
      },
      [&](std::size_t i, const Trial& trial) { summarize(trials[i], trial); });
  while (summaries.next() < objects.size()) summaries.end_object();
}

}  // namespace palpate::evaluation
