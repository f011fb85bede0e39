// SPDX-License-Identifier: Apache-2.0
// Contacts alone on objects that nobody chose: generated shapes and scans, by number of contacts.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <string_view>

#include "experiment.hpp"
#include "palpate/core/assets.hpp"
#include "palpate/core/parallel.hpp"
#include "palpate/core/statistics.hpp"
#include "palpate/localization/synthetic/grasp_scene.hpp"
#include "palpate/simulation/hand/load_hand.hpp"
#include "palpate/simulation/world/world.hpp"
#include "processor_time.hpp"

namespace {

using namespace palpate;
using namespace palpate::localization;

constexpr int kShapes = 30, kScenesOfShape = 2, kScenesOfScan = 12;
constexpr double kSure = 0.9;
constexpr double kMaxRotation = 5 * M_PI / 180, kMaxTranslation = 0.010;  // of a right pose
constexpr std::array kContacts = {3, 5, 10, 20, 60};
constexpr int kGrasps = 40;  // at most, for a scene of that many contacts

/// An object, the seeds of its scenes, and what makes them.
struct Subject {
  Subject(std::string its_name, std::uint64_t seed, int its_scenes)
      : name(std::move(its_name)),
        model(geometry::load_known_object(name)),
        mesh(model.object().mesh),
        first_seed(seed),
        scenes(its_scenes) {}
  std::string name;
  geometry::ObjectModel model;
  geometry::MeshQuery mesh;
  std::uint64_t first_seed;
  int scenes;
};

/// What became of one search.
struct Outcome {
  double stated = 0;     // probability of the best pose
  bool right = false;    // it is within 5 deg and 10 mm, modulo symmetry
  bool covered = false;  // the truth is in the smallest set of poses that holds 95 %
  bool certain = false;  // as its status says
  double seconds = 0;    // of the processor
  bool sure_and_wrong() const { return stated > kSure && !right; }
};

enum Method { kFast, kFull };
constexpr std::array<std::string_view, 2> kMethods = {"fast", "full"};
/// Of one scene, by method.
using Outcomes = std::vector<Outcome>;
using OutcomesOfMethods = std::array<Outcomes, kMethods.size()>;

Outcome search(const Subject& subject, const Evidence& evidence, const Eigen::Isometry3d& truth,
               Method method, const RandomStream& random) {
  Outcome outcome;
  const double start = experiment::processor_seconds();
  const Posterior posterior = method == kFast ? localize_fast(subject.model, evidence, random)
                                              : localize(subject.model, evidence, random);
  outcome.seconds = experiment::processor_seconds() - start;
  if (posterior.modes.empty()) return outcome;
  const auto& symmetries = subject.model.object().symmetries;
  const Mode& best = posterior.modes.front();
  outcome.stated = pose_probability(best);
  const PoseError error = pose_error(best.T_frame_object, truth, symmetries);
  outcome.right = error.rotation < kMaxRotation && error.translation < kMaxTranslation;
  outcome.covered = truth_in_credible_set(posterior, truth, symmetries);
  outcome.certain = posterior.status == PoseStatus::certain;
  return outcome;
}

std::array<Outcome, kMethods.size()> run_one(const Subject& subject, const hand::Description& hand,
                                             int contacts, std::uint64_t seed) {
  GraspSceneOptions scene_options;
  scene_options.contacts = contacts;
  scene_options.max_grasps = kGrasps;
  const RandomStream random(seed, "objects");
  const GraspScene scene =
      make_grasp_scene(subject.model, subject.mesh, hand, scene_options, random);
  SceneEvidenceOptions told;
  told.contacts = contacts;
  const Evidence evidence = scene_evidence(scene, told, random.fork("evidence"));
  const auto search_by = [&](Method method) {
    return search(subject, evidence, scene.truth, method, random.fork("search"));
  };
  return {search_by(kFast), search_by(kFull)};
}

OutcomesOfMethods run_subject(const experiment::Options& options, const Subject& subject,
                              const hand::Description& hand, int contacts) {
  std::vector<std::array<Outcome, kMethods.size()>> scenes(
      static_cast<std::size_t>(subject.scenes));
  parallel_for(scenes.size(), options.threads, [&](std::size_t i) {
    scenes[i] = run_one(subject, hand, contacts, subject.first_seed + i);
  });
  OutcomesOfMethods outcomes;
  for (const auto& scene : scenes) {
    for (std::size_t method = 0; method < scene.size(); ++method) {
      outcomes[method].push_back(scene[method]);
    }
  }
  return outcomes;
}

template <class Value>
double mean_of(const Outcomes& outcomes, Value value) {
  double sum = 0;
  for (const Outcome& outcome : outcomes) sum += static_cast<double>(std::invoke(value, outcome));
  return outcomes.empty() ? 0 : sum / static_cast<double>(outcomes.size());
}

/// Mean distance of the stated probability from the share right, over ten bins of equal numbers.
double calibration_error(Outcomes outcomes) {
  constexpr std::ptrdiff_t kBins = 10;
  std::ranges::stable_sort(outcomes, {}, &Outcome::stated);
  const auto count = std::ssize(outcomes);
  double error = 0;
  for (std::ptrdiff_t bin = 0; bin < kBins; ++bin) {
    const Outcomes part(outcomes.begin() + count * bin / kBins,
                        outcomes.begin() + count * (bin + 1) / kBins);
    error += static_cast<double>(part.size()) *
             std::abs(mean_of(part, &Outcome::stated) - mean_of(part, &Outcome::right));
  }
  return count == 0 ? 0 : error / static_cast<double>(count);
}

std::string rate(const Outcomes& outcomes, bool Outcome::*member) {
  const auto count = static_cast<std::size_t>(std::ranges::count(outcomes, true, member));
  const Interval interval = wilson_interval(count, outcomes.size());
  return fmt::format("{:.3f} [{:.2f}, {:.2f}]", mean_of(outcomes, member), interval.low,
                     interval.high);
}

void add_row(const std::string& name, std::string_view method, int contacts,
             const Outcomes& outcomes, experiment::Table& table) {
  std::vector<double> ms;
  for (const Outcome& outcome : outcomes) ms.push_back(1e3 * outcome.seconds);
  table.add_row(
      {name, std::string(method), std::to_string(contacts), std::to_string(outcomes.size()),
       rate(outcomes, &Outcome::right), fmt::format("{:.3f}", mean_of(outcomes, &Outcome::stated)),
       fmt::format("{:.0f}", mean_of(outcomes, &Outcome::sure_and_wrong) *
                                 static_cast<double>(outcomes.size())),
       fmt::format("{:.3f}", mean_of(outcomes, &Outcome::certain)),
       rate(outcomes, &Outcome::covered), fmt::format("{:.3f}", calibration_error(outcomes)),
       fmt::format("{:.0f}, {:.0f}, {:.0f}", median(ms), quantile(ms, 0.9), quantile(ms, 1))});
}

using Subjects = std::vector<std::unique_ptr<Subject>>;

Subjects generated(const experiment::Options& options) {
  Subjects subjects;
  const int count = options.quick ? 1 : kShapes;
  for (int i = 0; i < count; ++i) {
    const std::uint64_t seed = options.seed + static_cast<std::uint64_t>(i);
    subjects.push_back(std::make_unique<Subject>(fmt::format("generated:{}", seed), seed,
                                                 options.quick ? 1 : kScenesOfShape));
  }
  return subjects;
}

/// The scans of the folder PALPATE_DATA/ycb, if there is one.
Subjects scanned(const experiment::Options& options) {
  Subjects subjects;
  const char* const data = std::getenv("PALPATE_DATA");
  if (options.quick || !data) {
    fmt::print("without scans: PALPATE_DATA names no folder, or --quick\n");
    return subjects;
  }
  for (const auto& entry :
       std::filesystem::directory_iterator(std::filesystem::path(data) / "ycb")) {
    if (entry.path().extension() != ".ply") continue;
    subjects.push_back(
        std::make_unique<Subject>(entry.path().string(), options.seed, kScenesOfScan));
  }
  std::ranges::sort(subjects, {}, [](const auto& subject) { return subject->name; });
  return subjects;
}

std::vector<std::string> columns() {
  return {"objects",
          "search",
          "contacts",
          "scenes",
          "right",
          "stated",
          "stated > 0.9, wrong",
          "certain",
          "truth in the 95 % set",
          "calibration",
          "ms: median, 90 %, most"};
}

/// All subjects together, and each by itself.
void publish(const experiment::Options& options, const Subjects& subjects, const std::string& name,
             const std::string& title) {
  if (subjects.empty()) return;
  const auto hand = simulation::load_shadow_hand(asset("shadow_hand/right_hand.xml"));
  experiment::Table all(columns()), each(columns());
  for (const int contacts : kContacts) {
    OutcomesOfMethods pool;
    for (const auto& subject : subjects) {
      const auto outcomes = run_subject(options, *subject, hand, contacts);
      for (std::size_t m = 0; m < kMethods.size(); ++m) {
        add_row(std::filesystem::path(subject->name).stem().string(), kMethods[m], contacts,
                outcomes[m], each);
        pool[m].insert(pool[m].end(), outcomes[m].begin(), outcomes[m].end());
      }
    }
    for (std::size_t m = 0; m < kMethods.size(); ++m) {
      add_row(name, kMethods[m], contacts, pool[m], all);
    }
    if (options.quick) break;
  }
  each.publish(options, name + "_each", title + ", each");
  all.publish(options, name, title);
}

void objects(const experiment::Options& options) {
  publish(options, generated(options), "generated", "contacts alone, generated shapes");
  publish(options, scanned(options), "scans", "contacts alone, scanned objects");
}

}  // namespace

int main(int argc, char** argv) {
  return experiment::run(argc, argv, "localization_objects",
                         "Right, stated probability and coverage of the pose posterior on "
                         "generated shapes and scans, by number of contacts",
                         objects);
}
