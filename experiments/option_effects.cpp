// SPDX-License-Identifier: Apache-2.0
// Whether every option of `palpate pick` that is no expert's changes what the program does: each is
// set by itself, first lower, then higher, until that makes a difference in a job.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <ranges>
#include <stop_token>

#include "experiment.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/options.hpp"
#include "palpate/core/parallel.hpp"
#include "palpate/evaluation/trial.hpp"
#include "palpate/evaluation/trial_record.hpp"
#include "palpate/recording/sink.hpp"

namespace {

using namespace palpate;
using evaluation::TrialOptions;

/// A pick, with or without placing, whose options leave few of the skills unused.
struct Job {
  std::string name, object;
  std::vector<std::string> settings;
  std::vector<std::string> sections;  ///< beginnings of keys that it tries before other jobs
  bool only_these = false;            ///< it is slow, and tries no others
};

const std::vector<Job> kJobs = {
    {"spot", "box", {"place.target=0.15,0.1,0.5"}, {"place.", "start.", "world.", "safety."}},
    {"unsure", "mug", {"place.target=0.15,0.1,0.5"}, {"palpation."}},
    {"hanging",
     "box",
     {"estimate_before_lift=false", "palpation.certain=1", "palpation.min_gain_rate=0",
      "palpation.table_touches=0"},
     {"lower.", "withdraw."}},
    {"fixture", "box", {"place.target=fixture"}, {"place.fixture."}},
    {"regrasp",
     "box",
     {"place.target=stable_pose", "place.strategy=regrasp"},
     {"place.regrasp.", "place.stable_pose", "place.turn_press"}},
    {"fingers", "box", {"place.target=0.15,0.1,0.5", "place.strategy=fingers"}, {"place.fingers."}},
    {"biotac", "box", {"touch.source=biotac"}, {"touch."}, true},
    {"slippery", "bottle", {"world.hand_friction=0.3"}, {}},
    {"side", "bottle", {"explore.touches=0", "start.stable_pose=2"}, {"grasp.side"}},
    {"doubtful", "mug", {"place.target=0.15,0.1,0.5", "palpation.certain=0"}, {"place.certain"}},
};

/// Few touches and short searches: whether an option has an effect shows in a short pick, too.
const std::vector<std::string> kShort = {"calibrate.touches=6",
                                         "explore.touches=4",
                                         "explore.max_touches=6",
                                         "explore.refining=1",
                                         "estimation.search.proposals=20000",
                                         "estimation.search.particles=400"};

TrialOptions options_of(const Job& job) {
  TrialOptions options;
  for (const std::string& setting : kShort) apply_setting(setting, options);
  for (const std::string& setting : job.settings) apply_setting(setting, options);
  return options;
}

/// Other values that the field may have.
struct OtherValues {
  std::vector<std::string> operator()(const bool* value) const {
    return {*value ? "false" : "true"};
  }
  std::vector<std::string> operator()(const std::string* value) const {
    std::vector<std::string> words = {"random", "wrist", "regrasp", "biotac", "shadow-left"};
    std::erase(words, *value);
    return words;
  }
  template <class Number>
  std::vector<std::string> operator()(const RangedOption<Number>& option) const {
    const auto value = static_cast<double>(*option.value), low = static_cast<double>(option.low),
               high = std::min(static_cast<double>(option.high), low + 1e4);
    std::vector<std::string> others;
    for (const double other : {low, 2 * value, value / 2, (low + 3 * value) / 4, (low + high) / 2,
                               high, low + 1e-6 * (high - low), low + 1, low + 2, low + 3}) {
      const double rounded = std::is_integral_v<Number> ? std::round(other) : other;
      if (rounded != value && rounded >= low && rounded <= high) {
        others.push_back(fmt::format("{}", rounded));
      }
    }
    return others;
  }
};

void drop_wall_times(nlohmann::json& j) {
  if (j.is_object()) j.erase("wall_seconds");
  if (j.is_structured()) std::ranges::for_each(j, drop_wall_times);
}

/// Whether a recording of the trial would have the channels of BioTacs.
struct ChannelsSeen : recording::Sink {
  bool any = false;
  void frame(const recording::Frame& frame) override { any |= !frame.reading.biotacs.empty(); }
  void event(const recording::Event&) override {}
  void estimate(const recording::EstimateRecord&) override {}
  void belief(const recording::BeliefRecord&) override {}
};

/// What a job does with the usual options, or with one that is changed.
struct Course {
  std::vector<std::string> phases;
  std::string end;  ///< all that the trial came to
  bool refused = false;
};

/// Without its outcome in words, which may state how long planning took.
std::string describe(const skills::PhaseReport& phase) {
  return fmt::format("{} {} {} {}", phase.name, phase.robot_seconds, phase.peak_force,
                     phase.contacts);
}

/// @param usual  ends the trial after the first phase that is not as in this one
Course run(const geometry::ObjectModel& object, const TrialOptions& options, std::uint64_t seed,
           const Course* usual = nullptr) {
  Course course;
  std::stop_source stop;
  ChannelsSeen channels;
  skills::PhaseObserver observer;
  observer.on_end = [&](const skills::PhaseReport& report, double) {
    course.phases.push_back(describe(report));
    const std::size_t i = course.phases.size() - 1;
    if (usual && (i >= usual->phases.size() || course.phases[i] != usual->phases[i])) {
      stop.request_stop();
    }
  };
  try {
    auto record = evaluation::trial_to_json(
        evaluation::run_trial(object, options, seed, &channels, observer, stop.get_token()));
    drop_wall_times(record);
    course.end = record.dump() + (channels.any ? " with channels" : "");
  } catch (const BadInput&) {
    course.refused = true;
  }
  return course;
}

struct Effect {
  std::string job, value;  ///< empty: none was seen
};

class Effects {
 public:
  explicit Effects(const experiment::Options& options) : seed_(options.seed) {
    const std::size_t jobs = options.quick ? 1 : kJobs.size();
    for (const Job& job : kJobs | std::views::take(jobs)) {
      models_.emplace_back(geometry::load_known_object(job.object));
      usual_.push_back(run(models_.back(), options_of(job), seed_));
    }
  }

  /// All values in one job after the other: first in those of the key's section, the last of them
  /// first.
  [[nodiscard]] Effect of(const std::string& key) const {
    std::vector<std::size_t> order;
    for (std::size_t j = 0; j < models_.size(); ++j) {
      if (serves(kJobs[j], key)) {
        order.insert(order.begin(), j);
      } else if (!kJobs[j].only_these) {
        order.push_back(j);
      }
    }
    for (const std::size_t j : order) {
      for (const std::string& value : others(key, kJobs[j])) {
        if (differs(j, key + "=" + value)) return {kJobs[j].name, value};
      }
    }
    return {};
  }

 private:
  static bool serves(const Job& job, const std::string& key) {
    return std::ranges::any_of(job.sections,
                               [&](const auto& section) { return key.starts_with(section); });
  }

  [[nodiscard]] bool differs(std::size_t job, const std::string& setting) const {
    TrialOptions options = options_of(kJobs[job]);
    try {
      apply_setting(setting, options);
    } catch (const BadInput&) {
      return false;
    }
    const Course course = run(models_[job], options, seed_, &usual_[job]);
    if (course.refused) return false;
    return course.phases != usual_[job].phases || course.end != usual_[job].end;
  }

  static std::vector<std::string> others(const std::string& key, const Job& job) {
    TrialOptions options = options_of(job);
    for (const OptionField& field : option_fields(options)) {
      if (field.key == key) return std::visit(OtherValues{}, field.value);
    }
    return {};
  }

  std::uint64_t seed_;
  std::vector<geometry::ObjectModel> models_;
  std::vector<Course> usual_;
};

std::vector<std::string> public_keys(bool quick) {
  std::vector<std::string> keys;
  for (const OptionInfo& option : list_options(TrialOptions{})) {
    if (!option.key.starts_with(kExpertSection)) keys.push_back(option.key);
  }
  if (quick) keys = {"friction", "lift.hold"};
  return keys;
}

void effects(const experiment::Options& options) {
  const Effects all(options);
  const std::vector<std::string> keys = public_keys(options.quick);
  experiment::Table table({"option", "value", "job in which it makes a difference"});
  std::vector<std::string> without;
  parallel_ordered(
      keys.size(), options.threads, [&](std::size_t i) { return all.of(keys[i]); },
      [&](std::size_t i, const Effect& effect) {
        fmt::print(stderr, "{} {} {}\n", keys[i], effect.value, effect.job);
        table.add_row({keys[i], effect.value, effect.job.empty() ? "none" : effect.job});
        if (effect.job.empty()) without.push_back(keys[i]);
      });
  table.publish(
      options, "option_effects",
      fmt::format("{} of {} options make a difference", keys.size() - without.size(), keys.size()));
}

}  // namespace

int main(int argc, char** argv) {
  return experiment::run(argc, argv, "option_effects",
                         "Whether every option of a pick changes what the program does", effects);
}
